/* SPDX-License-Identifier: MIT
 * Gives the files that depend on the lane count other names, so that several builds of
 * them stand in one program; included by the compiler before each of them. */
#ifndef PLENOFIX_TESTS_LANES_H
#define PLENOFIX_TESTS_LANES_H

#define LANES_PASTE(lanes, name) lanes##_##name
#define LANES_NAME(lanes, name)  LANES_PASTE(lanes, name)
#define LANED(name)              LANES_NAME(LANES_PREFIX, name)

#define plfx_k_stripe             LANED(k_stripe)
#define plfx_k_pads               LANED(k_pads)
#define plfx_k_cost               LANED(k_cost)
#define plfx_k_cost_2d            LANED(k_cost_2d)
#define plfx_k_scale              LANED(k_scale)
#define plfx_k_pair               LANED(k_pair)
#define plfx_k_update             LANED(k_update)
#define plfx_k_slide              LANED(k_slide)
#define plfx_k_select             LANED(k_select)
#define plfx_k_unstripe           LANED(k_unstripe)
#define plfx_match_carve          LANED(match_carve)
#define plfx_match_start          LANED(match_start)
#define plfx_match_from           LANED(match_from)
#define plfx_match_row            LANED(match_row)
#define plfx_match_feed           LANED(match_feed)
#define plfx_match_enter          LANED(match_enter)
#define plfx_match_fetch          LANED(match_fetch)
#define plfx_match_texture_before LANED(match_texture_before)
#define plfx_match_drop           LANED(match_drop)
#define plfx_match_judge          LANED(match_judge)
#define plfx_match_texture_start  LANED(match_texture_start)
#define plfx_match_texture_row    LANED(match_texture_row)
#define plfx_match_texture_sums   LANED(match_texture_sums)
#define plfx_engine_carve         LANED(engine_carve)
#define plfx_engine_row           LANED(engine_row)
#define plfx_map_row              LANED(map_row)
#define plfx_map_put              LANED(map_put)
#define plfx_map_edge             LANED(map_edge)
#define plfx_sweep_ws             LANED(sweep_ws)
#define plfx_sweep_rows           LANED(sweep_rows)
#define plfx_sweep                LANED(sweep)

#endif
