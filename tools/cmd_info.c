/* SPDX-License-Identifier: MIT
 * info: what a lens table says. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "commands.h"
#include "common/args.h"
#include "common/err.h"
#include "common/json.h"
#include "common/out.h"
#include "common/table.h"

typedef struct request {
    const char *centres, *c_array;
    int all, json, devices;
} request;

typedef struct facts {
    double pitch, rotation, a, b, odd;
    double residual; /* rms of centres about the lattice, px */
    long dim, clipped, missing, interpolated;
} facts;

static double length(plfx_vec_q22 v)
{
    return hypot(v.x_q22, v.y_q22) / 4194304.0;
}

/* Lattice term of a centre. */
static void lattice_at(const plfx_lattice *l, int i, int j, double *x, double *y)
{
    double s = j % 2 != 0 ? 1.0 : 0.0;

    *x = l->origin.x_q16 / 65536.0 +
         (i * (double)l->a.x_q22 + j * (double)l->b.x_q22 + s * l->odd.x_q22) /
             4194304.0;
    *y = l->origin.y_q16 / 65536.0 +
         (i * (double)l->a.y_q22 + j * (double)l->b.y_q22 + s * l->odd.y_q22) /
             4194304.0;
}

static void count_flags(uint32_t flags, facts *f)
{
    f->dim += (flags & PLFX_LENS_DIM) != 0;
    f->clipped += (flags & PLFX_LENS_CLIPPED) != 0;
    f->missing += (flags & PLFX_LENS_MISSING) != 0;
    f->interpolated += (flags & PLFX_LENS_INTERP) != 0;
}

static void gather(const plfx_lut *lut, facts *f)
{
    const plfx_lattice *l = &lut->lattice;
    double sum = 0.0;
    long n = 0;
    int i, j;

    memset(f, 0, sizeof *f);
    f->pitch = plfx_lut_pitch_q16(lut) / 65536.0;
    f->rotation = atan2(l->a.y_q22, l->a.x_q22) * 57.29577951308232;
    f->a = length(l->a);
    f->b = length(l->b);
    f->odd = length(l->odd);
    for (j = 0; j < l->ny; j++) {
        for (i = 0; i < l->nx; i++) {
            uint32_t flags = plfx_lut_flags(lut, i, j);
            plfx_point c = plfx_lut_centre(lut, i, j);
            double x, y;
            count_flags(flags, f);
            if ((flags & PLFX_LENS_MISSING) == 0) {
                lattice_at(l, i, j, &x, &y);
                sum += pow(c.x_q16 / 65536.0 - x, 2) + pow(c.y_q16 / 65536.0 - y, 2);
                n++;
            }
        }
    }
    f->residual = n > 0 ? sqrt(sum / (double)n) : 0.0;
}

static const char *kind_name(const plfx_lut *lut)
{
    return lut->lattice.kind == PLFX_LATTICE_HEX ? "hexagonal" : "square";
}

static int print_text(const plft_table *t, const facts *f)
{
    const plfx_lut *l = &t->lut;

    printf("sensor      %d x %d, %d bits\n", l->sensor_w, l->sensor_h, l->sensor_bits);
    printf("lenses      %d x %d, %s\n", l->lattice.nx, l->lattice.ny, kind_name(l));
    printf(
        "pitch       %.5f px (rows %.5f, between rows %.5f), rotation %.4f degrees\n",
        f->pitch, f->a, f->b, f->rotation);
    printf("radius      %.2f px usable\n", l->radius_q8 / 256.0);
    printf("residual    %.4f px rms of the centres about the lattice\n", f->residual);
    printf("lenses not  missing %ld, dim %ld, clipped %ld, interpolated %ld\n",
           f->missing, f->dim, f->clipped, f->interpolated);
    printf("sections    residuals %u, flags %u, gains %u, dark %u, optics %u, text %u "
           "bytes\n",
           l->resi.length, l->flag.length, l->gain.length, l->dark.length,
           l->opti.length, l->meta.length);
    printf("table       %zu bytes, CRC %08x, camera %u\n", t->size, l->crc,
           l->camera_id);
    if (l->meta.length > 0) {
        printf("made by     %.*s\n", (int)l->meta.length,
               (const char *)(l->blob + l->meta.offset));
    }
    return 0;
}

static json_t *vector(plfx_vec_q22 v)
{
    return json_pack("[f,f]", v.x_q22 / 4194304.0, v.y_q22 / 4194304.0);
}

static int print_json(const plft_table *t, const facts *f)
{
    const plfx_lut *l = &t->lut;
    const plfx_lattice *g = &l->lattice;
    char crc[16];
    json_t *root;
    int rc;

    (void)snprintf(crc, sizeof crc, "%08x", (unsigned)l->crc);
    root = json_pack(
        "{s:[i,i],s:i,s:s,s:i,s:i,s:[f,f],s:o,s:o,s:o,s:f,s:f,s:f,s:f,s:I,s:I,s:I,s:I,"
        "s:I,"
        "s:s,s:I}",
        "sensor", l->sensor_w, l->sensor_h, "bits", l->sensor_bits, "lattice",
        kind_name(l), "nx", g->nx, "ny", g->ny, "origin", g->origin.x_q16 / 65536.0,
        g->origin.y_q16 / 65536.0, "a", vector(g->a), "b", vector(g->b), "odd",
        vector(g->odd), "pitch", f->pitch, "rotation_deg", f->rotation, "radius",
        l->radius_q8 / 256.0, "residual_rms", f->residual, "missing",
        (json_int_t)f->missing, "dim", (json_int_t)f->dim, "clipped",
        (json_int_t)f->clipped, "interpolated", (json_int_t)f->interpolated, "bytes",
        (json_int_t)t->size, "crc", crc, "camera", (json_int_t)l->camera_id);
    if (root == NULL) {
        return plft_fail(PLFT_DATA, "out of memory");
    }
    rc = plft_json_print(root);
    json_decref(root);
    return rc;
}

static int write_centres(const plfx_lut *lut, const char *path, int all)
{
    plft_out out;
    int i, j;

    if (plft_out_open(&out, path) != 0) {
        return PLFT_DATA;
    }
    fprintf(out.file, "row,col,x,y,flags\n");
    for (j = 0; j < lut->lattice.ny; j++) {
        for (i = 0; i < lut->lattice.nx; i++) {
            uint32_t flags = plfx_lut_flags(lut, i, j);
            plfx_point c = plfx_lut_centre(lut, i, j);
            if (all || (flags & PLFX_LENS_MISSING) == 0) {
                fprintf(out.file, "%d,%d,%.5f,%.5f,%u\n", j, i, c.x_q16 / 65536.0,
                        c.y_q16 / 65536.0, flags);
            }
        }
    }
    return plft_out_commit(&out);
}

/* For firmware: the table in flash. */
static int write_array(const plft_table *t, const char *path)
{
    plft_out out;
    size_t i;

    if (plft_out_open(&out, path) != 0) {
        return PLFT_DATA;
    }
    fprintf(out.file,
            "/* Lens table, CRC %08x: plfx_lut_open(&lut, plenofix_table, %zu). */\n"
            "#include <stdint.h>\n\nextern const uint8_t plenofix_table[%zu];\n"
            "const uint8_t plenofix_table[%zu] = {",
            (unsigned)t->lut.crc, t->size, t->size, t->size);
    for (i = 0; i < t->size; i++) {
        fprintf(out.file, "%s%u,", i % 16 == 0 ? "\n    " : " ", t->blob[i]);
    }
    fprintf(out.file, "\n};\n");
    return plft_out_commit(&out);
}

static int run(const request *r, const char *path)
{
    plft_table table;
    facts f;
    int rc = plft_table_read(&table, path);

    if (rc != 0) {
        return rc;
    }
    gather(&table.lut, &f);
    rc = r->centres != NULL ? write_centres(&table.lut, r->centres, r->all) : 0;
    rc = rc == 0 && r->c_array != NULL ? write_array(&table, r->c_array) : rc;
    if (rc == 0) {
        rc = r->json ? print_json(&table, &f) : print_text(&table, &f);
    }
    plft_table_free(&table);
    return rc;
}

static const plft_usage usage = {"info", "CAM.plut [options]",
                                 "What a lens table says, as text, CSV or C."};

int plft_cmd_info(int argc, char **argv)
{
    request r;
    const char *operand[1] = {NULL};
    int n, helped, rc;
    const plft_option options[] = {
        {"--centres", PLFT_TEXT, &r.centres, "C.csv", 0, 0,
         "write row,col,x,y,flags of the lenses"},
        {"--all", PLFT_FLAG, &r.all, NULL, 0, 0, "missing lenses too"},
        {"--c-array", PLFT_TEXT, &r.c_array, "T.c", 0, 0,
         "write the table as C source"},
        {"--json", PLFT_FLAG, &r.json, NULL, 0, 0, "print as JSON"},
        {"--devices", PLFT_FLAG, &r.devices, NULL, 0, 0,
         "instead of a table: what depth --device can name"},
        {NULL, PLFT_FLAG, NULL, NULL, 0, 0, NULL}};

    memset(&r, 0, sizeof r);
    rc = plft_args(argc, argv, &usage, options, operand, 1, &n, &helped);
    if (rc != 0 || helped) {
        return rc;
    }
    if (r.devices && n == 0) {
        return plft_print_devices();
    }
    return n == 1 && !r.devices ? run(&r, operand[0])
                                : plft_fail(PLFT_USAGE, "want CAM.plut, or --devices");
}
