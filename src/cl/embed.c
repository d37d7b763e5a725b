/* SPDX-License-Identifier: MIT
 * Build tool: writes the kernel source, the shared headers pasted before it, as a C
 * array. usage: embed OUT.c FILE ...   Lines with #include are dropped. */
#include <stdio.h>
#include <string.h>

static int paste(FILE *out, const char *path)
{
    char line[512];
    FILE *in = fopen(path, "r");

    if (!in) {
        fprintf(stderr, "embed: cannot read %s\n", path);
        return 1;
    }
    while (fgets(line, sizeof line, in)) { /* at most the file's lines */
        const char *p;
        if (strncmp(line, "#include", 8) == 0) {
            continue;
        }
        fputs("    ", out);
        for (p = line; *p; p++) {
            fprintf(out, "%d,", (unsigned char)*p);
        }
        fputs("\n", out);
    }
    fclose(in);
    return 0;
}

int main(int argc, char **argv)
{
    FILE *out = argc > 2 ? fopen(argv[1], "w") : NULL;
    int bad = !out;
    int i;

    if (bad) {
        fprintf(stderr, "usage: embed OUT.c FILE ...\n");
        return 2;
    }
    fputs("/* SPDX-License-Identifier: MIT */\n#include \"cl_state.h\"\n"
          "const char plfx_cl_source[] = {\n",
          out);
    for (i = 2; i < argc; i++) {
        bad |= paste(out, argv[i]);
    }
    fputs("    0};\n", out);
    return fclose(out) != 0 || bad;
}
