/* Broken on purpose: no licence line, a tab, a trailing blank. */
int plfx_planted;	 
/* TODO: see /home/me/notes */
