"""The table of alternate functions, against what is known of it in another form: signals and where they may go."""

from __future__ import annotations

import re

from targets.mcu.stm32h7.adc_inputs import CHANNELS
from targets.mcu.stm32h7.af_table import ALTERNATE_FUNCTIONS, PADS

# Ports A to G as in zephyrproject-rtos/hal_stm32, dts/st/h7/stm32h753zitx-pinctrl.dtsi.
BY_SIGNAL = {
    "USART1_TX": "PA9:7 PB6:7 PB14:4",
    "USART1_RX": "PA10:7 PB7:7 PB15:4",
    "USART2_TX": "PA2:7 PD5:7",
    "USART2_RX": "PA3:7 PD6:7",
    "USART3_TX": "PB10:7 PC10:7 PD8:7",
    "USART3_RX": "PB11:7 PC11:7 PD9:7",
    "UART4_TX": "PA0:8 PA12:6 PB9:8 PC10:8 PD1:8",
    "UART4_RX": "PA1:8 PA11:6 PB8:8 PC11:8 PD0:8",
    "UART5_TX": "PB6:14 PB13:14 PC12:8",
    "UART5_RX": "PB5:14 PB12:14 PD2:8",
    "USART6_TX": "PC6:7 PG14:7",
    "USART6_RX": "PC7:7 PG9:7",
    "UART7_TX": "PA15:11 PB4:11 PE8:7 PF7:7",
    "UART7_RX": "PA8:11 PB3:11 PE7:7 PF6:7",
    "UART8_TX": "PE1:8",
    "UART8_RX": "PE0:8",
    "LPUART1_TX": "PA9:3 PB6:8",
    "LPUART1_RX": "PA10:3 PB7:8",
    "USART1_CTS": "PA11:7",
    "USART2_CTS": "PA0:7 PD3:7",
    "USART3_CTS": "PB13:7 PD11:7",
    "UART4_CTS": "PB0:8 PB15:8",
    "UART5_CTS": "PC9:8",
    "USART6_CTS": "PG13:7 PG15:7",
    "UART7_CTS": "PE10:7 PF9:7",
    "UART8_CTS": "PD14:8",
    "USART1_RTS": "PA12:7",
    "USART2_RTS": "PA1:7 PD4:7",
    "USART3_RTS": "PB14:7 PD12:7",
    "UART4_RTS": "PA15:8 PB14:8",
    "UART5_RTS": "PC8:8",
    "USART6_RTS": "PG8:7 PG12:7",
    "UART7_RTS": "PE9:7 PF8:7",
    "UART8_RTS": "PD15:8",
    "I2C1_SCL": "PB6:4 PB8:4",
    "I2C1_SDA": "PB7:4 PB9:4",
    "I2C2_SCL": "PB10:4 PF1:4",
    "I2C2_SDA": "PB11:4 PF0:4",
    "I2C3_SCL": "PA8:4",
    "I2C3_SDA": "PC9:4",
    "I2C4_SCL": "PB6:6 PB8:6 PD12:4 PF14:4",
    "I2C4_SDA": "PB7:6 PB9:6 PD13:4 PF15:4",
    "FDCAN1_RX": "PA11:9 PB8:9 PD0:9",
    "FDCAN2_TX": "PB6:9 PB13:9",
    "SPI1_MISO": "PA6:5 PB4:5 PG9:5",
    "SPI2_MOSI": "PB15:5 PC1:5 PC3:5",
    "SPI2_SCK": "PA9:5 PA12:5 PB10:5 PB13:5 PD3:5",
    "SPI3_MOSI": "PB2:7 PB5:7 PC12:6 PD6:5",
    "SPI6_NSS": "PA4:8 PA15:7 PG8:5",
    "TIM1_CH1": "PA8:1 PE9:1",
    "TIM1_CH2": "PA9:1 PE11:1",
    "TIM1_CH3": "PA10:1 PE13:1",
    "TIM1_CH4": "PA11:1 PE14:1",
    "TIM1_CH1N": "PA7:1 PB13:1 PE8:1",
    "TIM1_CH2N": "PB0:1 PB14:1 PE10:1",
    "TIM1_CH3N": "PB1:1 PB15:1 PE12:1",
    "TIM2_CH1": "PA0:1 PA5:1 PA15:1",
    "TIM2_CH2": "PA1:1 PB3:1",
    "TIM2_CH3": "PA2:1 PB10:1",
    "TIM2_CH4": "PA3:1 PB11:1",
    "TIM3_CH1": "PA6:2 PB4:2 PC6:2",
    "TIM3_CH2": "PA7:2 PB5:2 PC7:2",
    "TIM3_CH3": "PB0:2 PC8:2",
    "TIM3_CH4": "PB1:2 PC9:2",
    "TIM4_CH1": "PB6:2 PD12:2",
    "TIM4_CH2": "PB7:2 PD13:2",
    "TIM4_CH3": "PB8:2 PD14:2",
    "TIM4_CH4": "PB9:2 PD15:2",
    "TIM5_CH1": "PA0:2",
    "TIM5_CH2": "PA1:2",
    "TIM5_CH3": "PA2:2",
    "TIM5_CH4": "PA3:2",
    "TIM8_CH1": "PC6:3",
    "TIM8_CH2": "PC7:3",
    "TIM8_CH3": "PC8:3",
    "TIM8_CH4": "PC9:3",
    "TIM8_CH1N": "PA5:3 PA7:3",
    "TIM8_CH2N": "PB0:3 PB14:3",
    "TIM8_CH3N": "PB1:3 PB15:3",
    "TIM12_CH1": "PB14:2",
    "TIM12_CH2": "PB15:2",
    "TIM13_CH1": "PA6:9 PF8:9",
    "TIM14_CH1": "PA7:9 PF9:9",
    "TIM15_CH1": "PA2:4 PE5:4",
    "TIM15_CH1N": "PA1:4 PE4:4",
    "TIM15_CH2": "PA3:4 PE6:4",
    "TIM16_CH1": "PB8:1 PF6:1",
    "TIM16_CH1N": "PB6:1 PF8:1",
    "TIM17_CH1": "PB9:1 PF7:1",
    "TIM17_CH1N": "PB7:1 PF9:1",
}


def test_where_a_signal_may_go():
    for signal, places in BY_SIGNAL.items():
        found = {
            f"{pin}:{number}"
            for pin, functions in ALTERNATE_FUNCTIONS.items()
            for number, signals in functions.items()
            if signal in signals and pin[1] in "ABCDEFG"
        }
        assert found == set(places.split()), signal


def test_every_pad_is_there_and_every_function_has_a_number():
    ports = {letter: sum(pin[1] == letter for pin in PADS) for letter in "ABCDEFGHIJK"}
    assert ports == dict.fromkeys("ABCDEFGHIJ", 16) | {"K": 8}
    for functions in ALTERNATE_FUNCTIONS.values():
        assert set(functions) <= set(range(16))
        assert functions[15] == ("EVENTOUT",)
    assert {pin for pins in CHANNELS.values() for pin in pins.values()} <= set(PADS)


# What each number may be, by the head of the table.
FAMILIES = {
    0: r"MCO\d|SW|J|NJ|TRACE|RTC|TRG|D[12]PWREN",
    1: r"TIM(1|2|16|17)_|LPTIM1|HRTIM",
    2: r"TIM(3|4|5|12)_|SAI1|HRTIM",
    3: r"TIM8_|LPTIM|LPUART1|DFSDM1|HRTIM",
    4: r"I2C|USART1|TIM15|LPTIM2|DFSDM1|HDMI",
    5: r"SPI|I2S|HDMI",
    6: r"SPI|I2S|SAI[13]|UART4|DFSDM1|I2C4",
    7: r"USART|UART7|SPI|I2S|SDMMC1",
    8: r"UART|LPUART1|SAI[24]|SPI6|SPDIF|SDMMC1",
    9: r"FDCAN|TIM1[34]|QUADSPI|FMC|LCD|SDMMC2|SAI4|SPDIF",
    10: r"SAI[24]|QUADSPI|SDMMC2|OTG|LCD|TIM8_BKIN_COMP",
    11: r"I2C4|UART7|SDMMC2|ETH|SWPMI|MDIOS|DFSDM1|TIM[18]_BKIN2?_COMP",
    12: r"FMC|SDMMC1|MDIOS|OTG|LCD|TIM[18]_BKIN2?_COMP",
    13: r"DCMI|LCD|COMP|TIM1_BKIN_COMP",
    14: r"LCD|UART5",
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
