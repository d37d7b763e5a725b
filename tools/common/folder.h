/* SPDX-License-Identifier: MIT
 * Folders of views: which pictures, in which order. */
#ifndef PLFT_FOLDER_H
#define PLFT_FOLDER_H

typedef struct plft_names {
    char **name; /* [n] file names without the folder, malloc'd */
    int n;
    int ignored;    /* PNG files that were left out ... */
    char some[160]; /* ... and the names of the first of them */
} plft_names;

/* PNG files whose stem ends in a number, by the numbers in their names (view_2_10 after
 * view_2_9).  pattern: shell pattern of the file name, or NULL.  0 or PLFT_DATA. */
int plft_folder_numbered(plft_names *names, const char *folder, const char *pattern);

void plft_names_free(plft_names *names);

/* Order of two names: runs of digits by their value, the rest by character. */
int plft_name_order(const char *a, const char *b);

/* "folder/name", malloc'd, or NULL after a message. */
char *plft_join(const char *folder, const char *name);

/* Make a folder if it is not there.  0 or PLFT_DATA. */
int plft_folder_make(const char *folder);

#endif
