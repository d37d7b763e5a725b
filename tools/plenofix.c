/* SPDX-License-Identifier: MIT
 * The front end: finds the sub-command and hands it its arguments. */
#include <stdio.h>
#include <string.h>

#include "commands.h"
#include "common/err.h"
#include "plenofix/version.h"

typedef struct entry {
    const char *name;
    plft_command *run;
    const char *about;
} entry;

/* In the order in which one works with a camera. */
static const entry commands[] = {
    {"plan", plft_cmd_plan, "what a camera would see, before it is built"},
    {"calibrate", plft_cmd_calibrate, "a lens table from a calibration frame"},
    {"check", plft_cmd_check, "has the lens lattice moved since the calibration?"},
    {"import-centres", plft_cmd_import_centres,
     "lens table from centres measured elsewhere"},
    {"info", plft_cmd_info, "what a lens table says"},
    {"views", plft_cmd_views, "sub-aperture views of a raw frame, as pictures"},
    {"depth", plft_cmd_depth, "slope, confidence and distance of every lens"},
    {"refocus", plft_cmd_refocus, "a picture focused after it was taken"},
    {"optics", plft_cmd_optics, "the line from slope to distance, from known targets"},
    {"evaluate", plft_cmd_evaluate, "a depth map against its truth"},
    {"simulate", plft_cmd_simulate, "frames of an imagined camera, with their truth"},
    {"grab", plft_cmd_grab, "a frame of a camera, as a picture"},
    {"live", plft_cmd_live, "maps of a camera or recording as they come"},
    {"record", plft_cmd_record, "frames of a camera into one file"},
    {"replay", plft_cmd_replay, "a recording, frame by frame"},
    {"select-rois", plft_cmd_select_rois, "regions with enough texture, for monitor"},
    {"self-test", plft_cmd_self_test, "noise floor and scale of regions on the bench"},
    {"monitor", plft_cmd_monitor, "displacement of regions and their modes"},
    {"decode", plft_cmd_decode, "telemetry of monitor, as tables"},
    {"bench", plft_cmd_bench, "time and memory of the core on this machine"},
    {"devices", plft_cmd_devices, "what depth --device can name"},
    {"help", plft_cmd_help, "this text, or that of a command: help COMMAND"},
};

#define COMMANDS (sizeof commands / sizeof commands[0])

static const entry *find(const char *name)
{
    size_t k;

    for (k = 0; k < COMMANDS; k++) {
        if (strcmp(commands[k].name, name) == 0) {
            return &commands[k];
        }
    }
    return NULL;
}

static int no_command(const char *name)
{
    return plft_fail(PLFT_USAGE, "no command %s; see plenofix help", name);
}

static int print_commands(void)
{
    size_t k;

    printf("plenofix %s: depth from plenoptic cameras, in fixed point\n\n"
           "usage: plenofix COMMAND [arguments]\n\n",
           PLFX_VERSION_STRING);
    for (k = 0; k < COMMANDS; k++) {
        printf("  %-16s %s\n", commands[k].name, commands[k].about);
    }
    printf("\nplenofix COMMAND --help tells its options.  Exit status: 0 done, 1 bad "
           "data, "
           "2 bad command line.\n");
    return 0;
}

int plft_cmd_help(int argc, char **argv)
{
    char flag[] = "--help";
    char *args[2];
    const entry *e;

    if (argc < 2 || strncmp(argv[1], "--", 2) == 0) {
        return print_commands();
    }
    e = find(argv[1]);
    if (e == NULL) {
        return no_command(argv[1]);
    }
    args[0] = argv[1];
    args[1] = flag;
    return e->run == plft_cmd_help ? print_commands() : e->run(2, args);
}

int main(int argc, char **argv)
{
    const entry *e;

    if (argc < 2) {
        return plft_fail(PLFT_USAGE, "want a command; see plenofix help");
    }
    if (strcmp(argv[1], "--version") == 0) {
        printf("plenofix %s\n", PLFX_VERSION_STRING);
        return 0;
    }
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0) {
        return print_commands();
    }
    e = find(argv[1]);
    return e != NULL ? e->run(argc - 1, argv + 1) : no_command(argv[1]);
}
