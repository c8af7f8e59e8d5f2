"""The table of alternate functions, against what is known of it in another form: signals and where they may go."""

from __future__ import annotations

import re

from targets.mcu.stm32f7.af_table import ALTERNATE_FUNCTIONS, PADS

BY_SIGNAL = {
    "USART1_TX": "PA9:7 PB6:7 PB14:4",
    "USART1_RX": "PA10:7 PB7:7 PB15:4",
    "USART2_TX": "PA2:7 PD5:7",
    "USART2_RX": "PA3:7 PD6:7",
    "USART3_TX": "PB10:7 PC10:7 PD8:7",
    "USART3_RX": "PB11:7 PC11:7 PD9:7",
    "UART4_TX": "PA0:8 PA12:6 PC10:8 PD1:8 PH13:8",
    "UART4_RX": "PA1:8 PA11:6 PC11:8 PD0:8 PH14:8 PI9:8",
    "UART5_TX": "PB6:1 PB9:7 PB13:8 PC12:8",
    "UART5_RX": "PB5:1 PB8:7 PB12:8 PD2:8",
    "USART6_TX": "PC6:8 PG14:8",
    "USART6_RX": "PC7:8 PG9:8",
    "UART7_TX": "PA15:12 PB4:12 PE8:8 PF7:8",
    "UART7_RX": "PA8:12 PB3:12 PE7:8 PF6:8",
    "UART8_TX": "PE1:8",
    "UART8_RX": "PE0:8",
    "USART6_CTS": "PG13:8 PG15:8",
    "USART6_RTS": "PG8:8 PG12:8",
    "I2C1_SCL": "PB6:4 PB8:4",
    "I2C1_SDA": "PB7:4 PB9:4",
    "I2C2_SCL": "PB10:4 PF1:4 PH4:4",
    "I2C4_SCL": "PB6:11 PB8:1 PD12:4 PF14:4 PH11:4",
    "I2C4_SDA": "PB7:11 PB9:1 PD13:4 PF15:4 PH12:4",
    "TIM1_CH2N": "PB0:1 PB14:1 PE10:1",
    "TIM2_CH1": "PA0:1 PA5:1 PA15:1",
    "TIM2_CH4": "PA3:1 PB11:1",
    "TIM3_CH1": "PA6:2 PB4:2 PC6:2",
    "TIM8_CH1N": "PA5:3 PA7:3 PH13:3",
    "TIM9_CH1": "PA2:3 PE5:3",
    "TIM12_CH1": "PB14:9 PH6:9",
    "TIM14_CH1": "PA7:9 PF9:9",
    "CAN1_RX": "PA11:9 PB8:9 PD0:9 PH14:9 PI9:9",
    "SPI2_SCK": "PA9:5 PA12:5 PB10:5 PB13:5 PD3:5 PI1:5",
}


def test_where_a_signal_may_go():
    for signal, places in BY_SIGNAL.items():
        found = {
            f"{pin}:{number}"
            for pin, functions in ALTERNATE_FUNCTIONS.items()
            for number, signals in functions.items()
            if signal in signals
        }
        assert found == set(places.split()), signal


def test_every_pad_is_there_and_every_function_has_a_number():
    ports = {letter: sum(pin[1] == letter for pin in PADS) for letter in "ABCDEFGHIJK"}
    assert ports == dict.fromkeys("ABCDEFGHIJ", 16) | {"K": 8}
    for functions in ALTERNATE_FUNCTIONS.values():
        assert set(functions) <= set(range(16))
        assert functions[15] == ("EVENTOUT",)


# What each number may be, by the head of the table.
FAMILIES = {
    0: r"MCO\d|SW|J|NJ|TRACE|RTC",
    1: r"TIM[12]_|I2C4|UART5",
    2: r"TIM[345]_",
    3: r"TIM(8|9|10|11)_|LPTIM1|DFSDM1|HDMI",
    4: r"I2C|USART1|HDMI",
    5: r"SPI|I2S",
    6: r"SPI|I2S|SAI1|UART4|DFSDM1",
    7: r"USART[123]|UART5|SPI|I2S|DFSDM1|SPDIF",
    8: r"UART|USART6|SAI2|SPI6|SPDIF",
    9: r"CAN|TIM1[234]|QUADSPI|FMC|LCD",
    10: r"SAI2|QUADSPI|SDMMC2|DFSDM1|OTG|LCD",
    11: r"I2C4|CAN3|SDMMC2|ETH",
    12: r"UART7|FMC|SDMMC1|MDIOS|OTG",
    13: r"DCMI|LCD|DSI",
    14: r"LCD",
    15: r"EVENTOUT",
}


def test_each_number_has_the_peripherals_of_its_column():
    for pin, functions in ALTERNATE_FUNCTIONS.items():
        for number, signals in functions.items():
            for signal in signals:
                assert re.match(FAMILIES[number], signal), (pin, number, signal)


def test_no_pin_has_a_signal_twice_in_the_table():
    twice = {
        (pin, signal)
        for pin, functions in ALTERNATE_FUNCTIONS.items()
        for signal in {name for names in functions.values() for name in names}
        if sum(signal in names for names in functions.values()) > 1
    }
    assert twice == set()
