/* SPDX-License-Identifier: MIT */
struct planted {
    int told_q8, silent_q12;
};
