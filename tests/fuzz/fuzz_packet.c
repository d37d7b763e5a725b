/* SPDX-License-Identifier: MIT
 * Packets.  First byte odd: the checksum is made to hold. */
#include "fuzz.h"

#include "plenofix/packet.h"
#include "bigend.h"
#include "packet_format.h"

static void use(const plfx_packet *p)
{
    static plfx_packet_region region[PLFX_PACKET_REGIONS_MAX];
    static plfx_packet_mode mode[PLFX_PACKET_MODES_MAX];
    plfx_packet_regions info;
    plfx_packet_health health;
    int32_t n = 0;
    int32_t got = 0;

    got += plfx_packet_get_regions(p, &info, region, PLFX_PACKET_REGIONS_MAX) == 0;
    got += plfx_packet_get_modes(p, mode, PLFX_PACKET_MODES_MAX, &n) == 0;
    got += plfx_packet_get_health(p, &health) == 0;
    fuzz_must(got == 1);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    fuzz_input in = {bytes, n};
    uint32_t mended = fuzz_u8(&in) & 1u;
    uint8_t *copy = fuzz_rest(&in);
    size_t whole = in.left >= 6 ? plfx_be_u16(copy + 4) + 7u : 0;
    plfx_packet p;

    if (mended && whole >= 8 && whole <= in.left) {
        plfx_be_put16(copy + whole - 2, plfx_crc16(copy, whole - 2));
    }
    if (plfx_packet_open(copy, in.left, &p) == PLFX_OK) {
        fuzz_must(p.whole <= in.left);
        use(&p);
    }
    free(copy);
    return 0;
}
