/* SPDX-License-Identifier: MIT
 * Self-test on a bare LEON3: the goldens, as TAP on the first serial port.  No C
 * library: the three memory functions of the core's contract are here. */
#include <stddef.h>
#include <stdint.h>

#include "golden/golden.h"

#define UART_DATA    (*(volatile uint32_t *)0x80000100u)
#define UART_STATUS  (*(volatile uint32_t *)0x80000104u)
#define UART_CONTROL (*(volatile uint32_t *)0x80000108u)

void *memset(void *to, int value, size_t n)
{
    unsigned char *p = to;
    while (n-- > 0u) {
        *p++ = (unsigned char)value;
    }
    return to;
}

void *memcpy(void *to, const void *from, size_t n)
{
    unsigned char *p = to;
    const unsigned char *q = from;
    while (n-- > 0u) {
        *p++ = *q++;
    }
    return to;
}

void *memmove(void *to, const void *from, size_t n)
{
    unsigned char *p = to;
    const unsigned char *q = from;
    if (p < q) {
        return memcpy(to, from, n);
    }
    while (n-- > 0u) {
        p[n] = q[n];
    }
    return to;
}

static void put(const char *s)
{
    for (; *s != '\0'; s++) {
        while ((UART_STATUS & 4u) == 0u) {
        }
        UART_DATA = (uint32_t)(unsigned char)*s;
    }
}

static void put_hex(uint32_t v)
{
    char text[9];
    int i;
    for (i = 0; i < 8; i++) {
        text[i] = "0123456789abcdef"[(v >> (28 - 4 * i)) & 15u];
    }
    text[8] = '\0';
    put(text);
}

int main(void)
{
    size_t k;
    int bad = 0;
    UART_CONTROL = 3u;
    for (k = 0; k < golden_count; k++) {
        uint32_t crc = golden_stages[k].run();
        int same = crc == golden_stages[k].crc;
        bad += !same;
        put(same ? "ok - " : "not ok - ");
        put(golden_stages[k].name);
        put(" ");
        put_hex(crc);
        put("\n");
    }
    put(bad == 0 ? "leon3: all equal\n" : "leon3: differences\n");
    return bad;
}
