"""Numbers of the texts that nobody measured: text -> number with its unit -> what it is."""

BASE = "base step, in machines/tflex.toml"
SPECIFICATIONS: dict[str, dict[str, str]] = {
    "README.md": {
        "50 s": "length of the paper's trajectory",
        "31 ×": "size of the constraints",
        "6 ×": "size of the platform's system",
        "2.0": "FMI 2.0",
        "3.11": "version of Python",
    },
    "docs/diagnose.md": {
        "95 %": "level of the intervals",
        "12 s": "length of a logged run",
        "1 %": "error of masses in the generator",
        "3 %": "error of stiffness in the generator",
        "5 %": "error of actuators in the generator",
        "15 %": "error of the Dahl width in the generator",
        "10 %": "largest error of masses of the machines in MuJoCo",
        "0.05": "default of a tolerance",
        "0.005": "default of a tolerance",
        "0.1": "default of a tolerance",
        "0.002": "default of a tolerance",
        "0.5 %": "error of parts as they are machined",
    },
    "docs/gateway.md": {
        "10 s": "length of a run of `flexhex drive`",
        "1 mrad": "how near the start a run needs no lift-off",
        "1 rad": "speed that the tests of the landing hold",
        "100 us": "limit for cyclictest",
        "100 ms": "watchdog in the drive's manual",
        "20 s": "length of the simulation",
        "0.25 ms": BASE,
        "6.12": "version of Linux",
    },
    "docs/glossary.md": {"0.25 ms": BASE, "2 s": "settling time", "1.0": "SSP 1.0"},
    "docs/import.md": {
        "0.25 ms": BASE,
        "0.12 s": "length of a simulation",
        "2 s": "length of a simulation",
        "15 ms": "how often ecos is read",
        "0.00025": BASE,
        "2.0": "FMI 2.0",
        "1.0": "SSP 1.0",
    },
    "docs/machines.md": {
        "12 s": "length of a logged run",
        "10 µrad": "limit below which machines are counted",
    },
    "docs/motion.md": {
        "0.25 ms": BASE,
        "2 s": "rest before the motion",
        "0.3 m": "neutral pose of the machine file",
        "25 %": "limit of the swing between rows",
    },
    "docs/method.md": {
        "1.96": "standard deviations of a 95 % interval",
        "3.5": "section of a book",
    },
    "docs/performance.md": {
        "2 ms": "length of a burst",
        "6 ×": "size of the platform's system",
        "0.25 ms": BASE,
    },
}
