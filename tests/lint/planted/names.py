# SPDX-License-Identifier: MIT
"""Takes what is not there."""
from names_beside import WIDTH

print(WIDTH, gone)
