/* SPDX-License-Identifier: MIT
 * Whole commands on one file, by the first byte: `import-centres` on a list of centres
 * as text or drawn on a lattice with faults, `plan` on optics.  A table that a command
 * leaves must open. */
#define _GNU_SOURCE
#include "fuzz.h"

#include "commands.h"
#include "plenofix/lut.h"

#include <fcntl.h>
#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>

enum { CENTRES, LATTICE, PLAN, KINDS };

static int quietly(plft_command *run, int argc, char **argv)
{
    int out = dup(1);
    int null = open("/dev/null", O_WRONLY | O_CLOEXEC);
    int rc;

    fuzz_must(out >= 0 && null >= 0 && fflush(stdout) == 0);
    (void)dup2(null, 1);
    rc = run(argc, argv);
    (void)fflush(stdout);
    (void)dup2(out, 1);
    (void)close(out);
    (void)close(null);
    return rc;
}

/* Centres of a lattice, some of them wrong, missing or twice. */
static void draw(FILE *file, fuzz_input *in)
{
    double pitch = fuzz_range(in, 300, 3000) / 100.0;
    double lean = fuzz_range(in, -900, 900) / 1000.0;
    int hex = (int)fuzz_u8(in) & 1;
    int nx = fuzz_range(in, 1, 12);
    int ny = fuzz_range(in, 1, 12);
    int bare = (int)fuzz_u8(in) & 1;

    for (int k = 0; k < nx * ny; k++) {
        int fault = (int)fuzz_u8(in);
        double x = pitch * (k % nx + (hex ? k / nx % 2 / 2.0 : 0.0)) + lean * (k / nx);
        double y = pitch * (k / nx) - lean * (k % nx) + (fault > 250 ? pitch * 40 : 0);
        if (fault == 250) {
            continue;
        }
        if (!bare) {
            (void)fprintf(file, "%d,%d,", k / nx + (fault == 249), k % nx);
        }
        (void)fprintf(file, "%.3f,%.3f\n", x + 10 + (fault - 128) / 500.0, y + 10);
    }
}

static void write_input(FILE *file, uint32_t kind, fuzz_input *in)
{
    if (kind == LATTICE) {
        draw(file, in);
    } else if (in->left) {
        (void)fwrite(in->at, 1, in->left, file);
    }
    (void)fflush(file);
}

static void must_open(const char *path)
{
    static uint64_t blob[1 << 15];
    FILE *file = fopen(path, "rb");
    plfx_lut lut;
    size_t n;

    fuzz_must(file != NULL);
    n = fread(blob, 1, sizeof blob, file);
    (void)fclose(file);
    fuzz_must(n == sizeof blob || plfx_lut_open(&lut, blob, n) == PLFX_OK);
}

static void import(char *path, int hex)
{
    static char table[] = "/tmp/plenofix-fuzz-0123456789.plut";
    char name[] = "import-centres";
    char size[] = "--size=640x480";
    char out[] = "-o";
    char lattice[] = "--lattice=hex";
    char smooth[] = "--smooth";
    char *argv[] = {name, path, size, out, table, hex ? lattice : smooth, NULL};

    (void)snprintf(table, sizeof table, "/tmp/plenofix-fuzz-%u.plut",
                   (unsigned)getpid() % 1000000000u);
    if (quietly(plft_cmd_import_centres, 6, argv) == 0) {
        must_open(table);
        (void)unlink(table);
    }
}

static void plan(char *path)
{
    char name[] = "plan";
    char optics[] = "--optics";
    char lenses[] = "--lenses=200x150";
    char json[] = "--json";
    char *argv[] = {name, optics, path, lenses, json, NULL};

    (void)quietly(plft_cmd_plan, 5, argv);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    fuzz_input in = {bytes, n};
    uint32_t kind = fuzz_u8(&in);
    int memory = memfd_create("input", 0);
    FILE *file = memory < 0 ? NULL : fdopen(memory, "wb");
    char path[32];

    fuzz_must(file != NULL);
    (void)snprintf(path, sizeof path, "/proc/self/fd/%d", memory);
    write_input(file, kind % KINDS, &in);
    if (kind % KINDS == PLAN) {
        plan(path);
    } else {
        import(path, (int)(kind / KINDS) & 1);
    }
    (void)fclose(file);
    return 0;
}
