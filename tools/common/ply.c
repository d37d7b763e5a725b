/* SPDX-License-Identifier: MIT */
#include "common/ply.h"

#include <stdint.h>
#include <string.h>

#include "common/out.h"

static void put_float(FILE *file, float v)
{
    uint32_t bits;
    int k;

    memcpy(&bits, &v, sizeof bits);
    for (k = 0; k < 4; k++) {
        (void)fputc((int)(bits >> (8 * k) & 255u), file);
    }
}

int plft_ply_write(const char *path, const plft_point3 *p, size_t n,
                   const char *comment)
{
    plft_out out;
    size_t i;
    int rc = plft_out_open(&out, path);

    if (rc != 0) {
        return rc;
    }
    fprintf(out.file,
            "ply\nformat binary_little_endian 1.0\ncomment %s\nelement vertex %zu\n"
            "property float x\nproperty float y\nproperty float z\n"
            "property float confidence\nproperty float sigma\nend_header\n",
            comment, n);
    for (i = 0; i < n; i++) {
        put_float(out.file, p[i].x);
        put_float(out.file, p[i].y);
        put_float(out.file, p[i].z);
        put_float(out.file, p[i].confidence);
        put_float(out.file, p[i].sigma);
    }
    return plft_out_commit(&out);
}
