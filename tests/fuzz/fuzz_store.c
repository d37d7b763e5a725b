/* SPDX-License-Identifier: MIT
 * The two-slot store on a device full of anything: opened, read, written, opened again
 * after a fault in the middle. */
#include "fuzz.h"

#include "ram/ram.h"
#include "store/store.h"

#include "plenofix/lut.h"

#define SIZE  2048u
#define BLOCK 256u

static uint8_t device[SIZE], worn[SIZE], table[256], back[SIZE];

static uint32_t make_table(void)
{
    plfx_lut_desc d;

    memset(&d, 0, sizeof d);
    d.sensor_w = 20;
    d.sensor_h = 20;
    d.sensor_bits = 8;
    d.lattice.nx = 1;
    d.lattice.ny = 1;
    d.lattice.origin.x_q16 = 65536;
    d.lattice.origin.y_q16 = 65536;
    d.lattice.a.x_q22 = 10 << 22;
    d.lattice.b.y_q22 = 10 << 22;
    fuzz_must(plfx_lut_write(&d, table, sizeof table) == PLFX_OK);
    return (uint32_t)plfx_lut_bytes(&d);
}

static void read_back(const plfx_block *block, int sound)
{
    plfx_store s;

    if (plfx_store_open(&s, block, 0) != PLFX_OK || s.slot < 0) {
        return;
    }
    fuzz_must(s.length <= s.capacity && s.length <= sizeof back);
    fuzz_must(plfx_store_read(&s, back, sizeof back) == PLFX_OK || !sound);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    fuzz_input in = {bytes, n};
    uint32_t length = make_table();
    plfx_store s;
    plfx_ram ram;
    int32_t fault;
    uint32_t when;

    fuzz_must(plfx_ram_init(&ram, device, worn, SIZE, BLOCK, 8) == PLFX_OK);
    fault = fuzz_range(&in, PLFX_RAM_SOUND, PLFX_RAM_DEAF);
    when = fuzz_u8(&in) % 64u;
    ram.tear = fuzz_u16(&in);
    memcpy(device, in.at, in.left < SIZE ? in.left : SIZE);
    read_back(&ram.block, 1);
    if (plfx_store_open(&s, &ram.block, 0) == PLFX_OK) {
        plfx_status status;
        ram.count = 0;
        ram.when = when;
        ram.fault = (uint8_t)fault;
        status = plfx_store_write(&s, table, length);
        plfx_ram_power(&ram);
        read_back(&ram.block, 1);
        fuzz_must(status != PLFX_OK || fault != PLFX_RAM_SOUND ||
                  memcmp(back, table, length) == 0);
    }
    return 0;
}
