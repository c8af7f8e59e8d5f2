#include "about.h"

#include "adc_f1.h"
#include "cpu.h"
#include "port.h"
#include "spi_f1.h"
#include "usart.h"

#include <stddef.h>

/* Found in the file by sources.py, without loading it. */
#define MARK "hilbench core sources "

static const char mark[] = MARK HIL_SOURCES_DIGEST;

#define TEXT_OF(name) #name
#define TEXT(name) TEXT_OF(name)
#define SIZE_OF(name) ((uint32_t)sizeof ((struct STRUCT *)0)->name)
#define PLACE_OF(name) ((uint32_t)offsetof(struct STRUCT, name))
#define WHOLE {TEXT(STRUCT), "", "", 0, (uint32_t)sizeof(struct STRUCT), 0},
#define ONE(type, name) {TEXT(STRUCT), #name, #type, PLACE_OF(name), SIZE_OF(name), 0},
#define MANY(type, name, count) {TEXT(STRUCT), #name, #type, PLACE_OF(name), SIZE_OF(name), count},

static const struct hil_row rows[] = {
#define STRUCT hil_row
    WHOLE HIL_ROW_FIELDS(ONE, MANY)
#undef STRUCT
#define STRUCT hil_state
    WHOLE HIL_STATE_FIELDS(ONE, MANY)
#undef STRUCT
#define STRUCT hil_exceptions
    WHOLE HIL_EXCEPTIONS_FIELDS(ONE, MANY)
#undef STRUCT
#define STRUCT hil_hit
    WHOLE HIL_HIT_FIELDS(ONE, MANY)
#undef STRUCT
#define STRUCT hil_access
    WHOLE HIL_ACCESS_FIELDS(ONE, MANY)
#undef STRUCT
#define STRUCT hil_time
    WHOLE HIL_TIME_FIELDS(ONE, MANY)
#undef STRUCT
#define STRUCT hil_registers
    WHOLE HIL_REGISTERS_FIELDS(ONE, MANY)
#undef STRUCT
#define STRUCT hil_port_pins
    WHOLE HIL_PORT_FIELDS(ONE, MANY)
#undef STRUCT
#define STRUCT hil_line
    WHOLE HIL_LINE_FIELDS(ONE, MANY)
#undef STRUCT
#define STRUCT hil_adc_inputs
    WHOLE HIL_ADC_INPUTS_FIELDS(ONE, MANY)
#undef STRUCT
#define STRUCT hil_spi_wires
    WHOLE HIL_SPI_WIRES_FIELDS(ONE, MANY)
#undef STRUCT
#define STRUCT hil_systick
    WHOLE HIL_SYSTICK_FIELDS(ONE, MANY)
#undef STRUCT
    {NULL, NULL, NULL, 0, 0, 0},
};

const char *hil_sources_digest(void) { return mark + sizeof MARK - 1; }

const char *hil_compiler(void) {
#if defined(__clang__)
    return "clang " __clang_version__;
#elif defined(__GNUC__)
    return "gcc " __VERSION__;
#else
    return "unknown compiler";
#endif
}

const struct hil_row *hil_layout(void) { return rows; }
