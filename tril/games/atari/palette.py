"""The emulator's colours by palette value."""

from functools import cache

import numpy as np
import numpy.typing as npt

# NTSC colours as hexadecimal RGB: one line per hue, eight luminances each.
_NTSC_COLOURS = """
000000 4a4a4a 6f6f6f 8e8e8e aaaaaa c0c0c0 d6d6d6 ececec
484800 69690f 86861d a2a22a bbbb35 d2d240 e8e84a fcfc54
7c2c00 904811 a26221 b47a30 c3903d d2a44a dfb755 ecc860
901c00 a33915 b55328 c66c3a d5824a e39759 f0aa67 fcbc74
940000 a71a1a b83232 c84848 d65c5c e46f6f f08080 fc9090
840064 97197a a8308f b846a2 c659b3 d46cc3 e07cd2 ec8ce0
500084 68199a 7d30ad 9246c0 a459d0 b56ce0 c57cee d48cfc
140090 331aa3 4e32b5 6848c6 7f5cd5 956fe3 a980f0 bc90fc
000094 181aa7 2d32b8 4248c8 545cd6 656fe4 7580f0 8490fc
001c88 183b9d 2d57b0 4272c2 548ad2 65a0e1 75b5ef 84c8fc
003064 185080 2d6d98 4288b0 54a0c5 65b7d9 75cceb 84e0fc
004030 18624e 2d8169 429e82 54b899 65d1ae 75e7c2 84fcd4
004400 1a661a 328432 48a048 5cba5c 6fd26f 80e880 90fc90
143c00 355f18 527e2d 6e9c42 87b754 9ed065 b4e775 c8fc84
303800 505916 6d762b 88923e a0ab4f b7c25f ccd86e e0ec7c
482c00 694d14 866a26 a28638 bb9f47 d2b656 e8cc63 fce070
"""

_LUMA = (0.2989, 0.5870, 0.1140)
"""Weights of red, green and blue in the emulator's grayscale."""


@cache
def palette_rgb() -> npt.NDArray[np.uint8]:
    """Return the colours, uint8 (256, 3) RGB, indexed by palette value; read-only.

    Colours are at the even values, the only ones on a screen; the odd value after each is its gray.
    """
    colours = np.frombuffer(bytes.fromhex(_NTSC_COLOURS), np.uint8).reshape(-1, 3)
    palette = np.empty((256, 3), np.uint8)
    palette[0::2] = colours
    palette[1::2] = np.rint(colours @ np.array(_LUMA))[:, None]
    palette.setflags(write=False)
    return palette


@cache
def palette_grayscale() -> npt.NDArray[np.uint8]:
    """Return the emulator's grayscale, uint8 (256,) from 0 to 255, by palette value; read-only."""
    grays: npt.NDArray[np.uint8] = np.rint(palette_rgb() @ np.array(_LUMA)).astype(np.uint8)
    grays.setflags(write=False)
    return grays
