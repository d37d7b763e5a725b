/* SPDX-License-Identifier: MIT
 * Sub-commands of `figures`, the helper of tools/demo: argv[0] is their name; each
 * returns the exit status of the program. */
#ifndef PLFT_FIGURES_H
#define PLFT_FIGURES_H

typedef int plft_figure(int argc, char **argv);

plft_figure plft_figure_run;
plft_figure plft_figure_zoom;
plft_figure plft_figure_map;
plft_figure plft_figure_sheet;
plft_figure plft_figure_score;

#endif
