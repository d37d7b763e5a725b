/* SPDX-License-Identifier: MIT
 * The order of a real array's 233,387 measured centres.  Skipped as a whole where the
 * file is missing: CMocka's skip() prints "not ok", which counts as failed. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "calib/order.h"

enum { N = 233387, NX = 539, EVEN = 217, ODD = 216 };

static FILE *file;

static double float_le(const unsigned char *b)
{
    const uint32_t bits = (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 |
                          (uint32_t)b[3] << 24;
    float v;

    memcpy(&v, &bits, sizeof v);
    return v;
}

/* The file holds even rows, then odd ones, column by column. */
static void order_of_a_real_array_is_exact(void **state)
{
    unsigned char *raw = malloc(8u * N);
    double *xy = malloc(2u * N * sizeof *xy);
    plft_order o;
    int k;

    (void)state;
    assert_int_equal(fread(raw, 8, N, file), N);
    for (k = 0; k < 2 * N; k++) {
        xy[k] = float_le(raw + 4 * k);
    }
    assert_int_equal(plft_order_points(xy, N, PLFT_LATTICE_AUTO, &o), 0);
    assert_int_equal(o.placed, N);
    for (k = 0; k < N; k++) {
        const int even = k < NX * EVEN, q = even ? k : k - NX * EVEN;
        const int rows = even ? EVEN : ODD;
        assert_int_equal(o.col[k], q / rows);
        assert_int_equal(o.row[k], 2 * (q % rows) + !even);
    }
    plft_order_free(&o);
    free(raw);
    free(xy);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(order_of_a_real_array_is_exact),
    };
    int failed;

    file =
        fopen(DATA "/illum_lens_centres/illum_lenslet_locs_233387x2_f32le.bin", "rb");
    if (file == NULL) {
        printf("1..0 # SKIP no ../shared/data/illum_lens_centres\n");
        return 0;
    }
    cmocka_set_message_output(CM_OUTPUT_TAP);
    failed = cmocka_run_group_tests(tests, NULL, NULL);
    fclose(file);
    return failed;
}
