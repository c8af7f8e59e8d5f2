/* Which instructions were executed.
 *
 * Code is decoded when it is first executed, never before: what has been decoded has been executed, and to know that
 * costs nothing. What is forgotten (`hil_forget`) is remembered here first. An instruction that an IT block passes over
 * is not decoded; one that faults is, and one before which a breakpoint stops. */
#include "cpu.h"

#include <stdlib.h>

/* Remember from now on what is forgotten. Returns false if there is no memory left. */
HIL_EXPORT bool hil_cover(struct hil_cpu *cpu) {
  for (uint32_t n = 0; n < cpu->region_count; n++) {
    struct hil_region *region = &cpu->regions[n];
    if (region->data && !region->executed) {
      region->executed = calloc(region->size / 2, 1);
      if (!region->executed)
        return false;
    }
  }
  return true;
}

/* Half-words `first` to `last` are about to be forgotten. */
void hil_remember(struct hil_region *region, size_t first, size_t last) {
  if (!region->executed || !region->ops)
    return;
  for (size_t at = first; at < last; at++)
    if (region->ops[at].jump)
      region->executed[at] = 1;
}

/* Return a byte for each half-word of the memory at an address: 1 where an instruction begins that was executed. NULL if
 * there is no memory, or nobody has asked to remember. It is this core's, and of this moment. */
HIL_EXPORT const uint8_t *hil_executed(struct hil_cpu *cpu, uint32_t base) {
  struct hil_region *region = hil_region_at(cpu, base);
  if (!region || !region->executed)
    return NULL;
  hil_remember(region, 0, region->size / 2);
  return region->executed;
}
