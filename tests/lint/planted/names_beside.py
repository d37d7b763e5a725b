# SPDX-License-Identifier: MIT
"""Has a height, no width."""
HEIGHT = 480
