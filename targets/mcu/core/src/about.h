/* What the library says of itself when it is loaded. */
#ifndef HIL_ABOUT_H
#define HIL_ABOUT_H

#include "layout.h"

/* The digest of the sources and flags it was compiled from, as in sources.py. */
HIL_EXPORT const char *hil_sources_digest(void);

/* The compiler's name and version. */
HIL_EXPORT const char *hil_compiler(void);

/* The rows of all structs that Python sees; one without a structure ends them. */
HIL_EXPORT const struct hil_row *hil_layout(void);

#endif
