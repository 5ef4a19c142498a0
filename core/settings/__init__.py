"""What a print is made with: every setting, the presets that set some of them, and the printers.

All settings are declared in `print_settings.py`, those of the pattern in `pattern_settings.py`.
"""

from .print_settings import PrintSettings as PrintSettings
