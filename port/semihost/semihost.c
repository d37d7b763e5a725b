/* SPDX-License-Identifier: MIT */
#include "semihost.h"

#include <string.h>

/* Operations, and what they mean by their argument block. */
#define SYS_OPEN          0x01u
#define SYS_CLOSE         0x02u
#define SYS_WRITE0        0x04u
#define SYS_WRITE         0x05u
#define SYS_READ          0x06u
#define SYS_FLEN          0x0cu
#define SYS_GET_CMDLINE   0x15u
#define SYS_EXIT_EXTENDED 0x20u

#define MODE_READ  1u       /* "rb" */
#define MODE_WRITE 5u       /* "wb" */
#define STOPPED    0x20026u /* the application ended by itself */

/* r0 operation, r1 its argument; the answer in r0. */
static int32_t ask(uint32_t operation, const void *argument)
{
    register uint32_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;

    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return (int32_t)r0;
}

static uint32_t address(const void *p)
{
    return (uint32_t)(uintptr_t)p;
}

int32_t plfx_semihost_open(const char *path, int32_t write)
{
    uint32_t block[3];
    int32_t file;

    block[0] = address(path);
    block[1] = write ? MODE_WRITE : MODE_READ;
    block[2] = (uint32_t)strlen(path);
    file = ask(SYS_OPEN, block);
    return file > 0 ? file : (int32_t)PLFX_E_IO;
}

/* Both calls return the number of bytes that were not moved. */
static plfx_status move(uint32_t operation, int32_t file, const void *data, uint32_t n)
{
    uint32_t block[3];

    block[0] = (uint32_t)file;
    block[1] = address(data);
    block[2] = n;
    return ask(operation, block) == 0 ? PLFX_OK : PLFX_E_IO;
}

plfx_status plfx_semihost_read(int32_t file, void *data, uint32_t n)
{
    return move(SYS_READ, file, data, n);
}

plfx_status plfx_semihost_write(int32_t file, const void *data, uint32_t n)
{
    return move(SYS_WRITE, file, data, n);
}

uint32_t plfx_semihost_size(int32_t file)
{
    uint32_t block = (uint32_t)file;
    int32_t n = ask(SYS_FLEN, &block);

    return n > 0 ? (uint32_t)n : 0u;
}

void plfx_semihost_close(int32_t file)
{
    uint32_t block = (uint32_t)file;

    (void)ask(SYS_CLOSE, &block);
}

plfx_status plfx_semihost_arguments(char *line, uint32_t n)
{
    uint32_t block[2];

    block[0] = address(line);
    block[1] = n;
    return ask(SYS_GET_CMDLINE, block) == 0 ? PLFX_OK : PLFX_E_IO;
}

void plfx_semihost_print(const char *text)
{
    (void)ask(SYS_WRITE0, text);
}

void plfx_semihost_exit(int32_t status)
{
    uint32_t block[2];

    block[0] = STOPPED;
    block[1] = (uint32_t)status;
    for (;;) { /* the host ends it: at most one round */
        (void)ask(SYS_EXIT_EXTENDED, block);
    }
}
