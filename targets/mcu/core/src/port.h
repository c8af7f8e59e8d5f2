/* A port of pins: see port.c. */
#ifndef HIL_PORT_H
#define HIL_PORT_H

#include "layout.h"

/* alone: pins whose latch may change without Python. shown: of them those whose level follows the latch; the others are
 *   no pins. noted: of them those whose edges are written down.
 * asked: what is read of the levels is for Python to say.
 * changes: how many were written down that Python has not taken. behind: there are some, or others. */
#define HIL_PORT_FIELDS(ONE, MANY) \
    ONE(uint32_t, alone) ONE(uint32_t, shown) ONE(uint32_t, noted) ONE(uint32_t, asked) ONE(uint32_t, changes) \
    ONE(uint32_t, behind)
HIL_STRUCT(hil_port_pins, HIL_PORT_FIELDS);

#endif
