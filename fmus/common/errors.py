"""The few errors that flexhex raises for a user's mistake: what, where, how to mend it."""


class FlexhexError(Exception):
    """A mistake that the user can mend; `exit_code` is what the command line ends with."""

    exit_code = 2


class UsageError(FlexhexError):
    """A wrong command, option or combination of them."""

    exit_code = 2


class MachineError(FlexhexError):
    """A machine file that does not describe a machine."""

    exit_code = 3


class LogError(FlexhexError):
    """A measured or simulated log that cannot be read or does not hold what is needed."""

    exit_code = 3


class OutputError(FlexhexError):
    """A file or folder that cannot be written."""

    exit_code = 3


class InterfaceError(FlexhexError):
    """An interface or wiring that contradicts itself."""

    exit_code = 3


class StartValueError(InterfaceError):
    """A start value outside its variable's range; `variable` is the variable's name."""

    def __init__(self, variable: str, text: str) -> None:
        super().__init__(text)
        self.variable = variable


class BuildError(FlexhexError):
    """Code generation or compilation failed."""

    exit_code = 4


class RunError(FlexhexError):
    """An FMU refused a call while the system was running."""

    exit_code = 1
