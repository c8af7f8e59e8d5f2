/* The structs that Python sees. The fields of each are listed once; from the list come the struct and its rows in the
   table of about.c, and from the table library.py makes its ctypes.Structure:

       #define HIL_CPU_FIELDS(ONE, MANY) \
           ONE(uint64_t, cycles) \
           MANY(uint32_t, r, 16)
       HIL_STRUCT(hil_cpu, HIL_CPU_FIELDS);

   Types: those of stdint.h, float, double, const char *, void *, and structs that stand before it in the table. */
#ifndef HIL_LAYOUT_H
#define HIL_LAYOUT_H

#include <stdint.h>

#define HIL_EXPORT __attribute__((visibility("default")))

#define HIL_MEMBER(type, name) type name;
#define HIL_MEMBERS(type, name, count) type name[count];
#define HIL_STRUCT(tag, FIELDS) struct tag { FIELDS(HIL_MEMBER, HIL_MEMBERS) }

/* A row of the table. A struct's own row has an empty field and type, and stands before those of its fields; `count`
   is the number of elements of an array, else 0; `offset` and `size` are in bytes, `size` that of a whole array. */
#define HIL_ROW_FIELDS(ONE, MANY) \
    ONE(const char *, structure) \
    ONE(const char *, field) \
    ONE(const char *, type) \
    ONE(uint32_t, offset) \
    ONE(uint32_t, size) \
    ONE(uint32_t, count)
HIL_STRUCT(hil_row, HIL_ROW_FIELDS);

#endif
