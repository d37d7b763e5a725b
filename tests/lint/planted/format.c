/* SPDX-License-Identifier: MIT
 * Broken on purpose: layout. */
int plfx_planted(int v) { if (v) return 1; return 0; }
