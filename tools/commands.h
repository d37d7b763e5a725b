/* SPDX-License-Identifier: MIT
 * Sub-commands: plft_cmd_NAME() lives in cmd_NAME.c; argv[0] is its name.  Each returns
 * the exit status of the program. */
#ifndef PLFT_COMMANDS_H
#define PLFT_COMMANDS_H

typedef int plft_command(int argc, char **argv);

plft_command plft_cmd_bench;
plft_command plft_cmd_calibrate;
plft_command plft_cmd_decode;
plft_command plft_cmd_check;
plft_command plft_cmd_depth;
plft_command plft_cmd_devices;
plft_command plft_cmd_evaluate;
plft_command plft_cmd_grab;
plft_command plft_cmd_help;
plft_command plft_cmd_import_centres;
plft_command plft_cmd_info;
plft_command plft_cmd_monitor;
plft_command plft_cmd_optics;
plft_command plft_cmd_plan;
plft_command plft_cmd_refocus;
plft_command plft_cmd_live;
plft_command plft_cmd_record;
plft_command plft_cmd_replay;
plft_command plft_cmd_select_rois;
plft_command plft_cmd_self_test;
plft_command plft_cmd_simulate;
plft_command plft_cmd_views;

/* The lines of `devices`, for `info --devices` too. */
int plft_print_devices(void);

#endif
