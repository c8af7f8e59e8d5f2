"""The udev rules that come with hilbench: where they are, whether they are installed, how they get there.

There is one file, ``udev/70-hilbench.rules``; a wheel holds a copy of it. It names the group ``dialout``, and what is
installed names the group that owns serial ports on this machine.
"""

from __future__ import annotations

import contextlib
import re
import shlex
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

import hilbench
from hilbench.errors import HilbenchError, UnavailableError, UsageError
from hilbench.files.host import Host
from hilbench.udev.rules import Problem, parse_rules, problems_of

__all__ = [
    "INSTALL_BY",
    "RULES_FOLDER",
    "RULES_NAME",
    "Checked",
    "Installed",
    "Verified",
    "check_rules",
    "group_to_install",
    "install_by",
    "install_rules",
    "installed_rules",
    "port_group",
    "reload_rules",
    "rules_text",
    "verify_rules",
]

RULES_NAME = "70-hilbench.rules"
RULES_FOLDER = "/etc/udev/rules.d"
INSTALL_BY = 'sudo "$(command -v hilbench)" udev --install'
"""How a person installs them, also where hilbench is in an environment of its own that root does not look into."""

# Where udev looks, the strongest first: udev(7), "Rules files".
_FOLDERS = (RULES_FOLDER, "/run/udev/rules.d", "/usr/local/lib/udev/rules.d", "/usr/lib/udev/rules.d")
_SHIPPED_GROUP = "dialout"
# Who owns serial ports: Debian, Ubuntu and Fedora have dialout, Arch has uucp.
_GROUPS = (_SHIPPED_GROUP, "uucp")
_VERIFIES_SINCE = 254
_GROUP_NAME = re.compile(r"[a-z_][a-z0-9_-]*")
_RELOAD = (
    ("udevadm", "control", "--reload-rules"),
    ("udevadm", "trigger", "--subsystem-match=usb", "--subsystem-match=usb-serial", "--subsystem-match=tty"),
)
_RELOAD_BY = " && ".join(f"sudo {' '.join(command)}" for command in _RELOAD)


@dataclass(frozen=True, slots=True, kw_only=True)
class Installed:
    """Rules of our name where udev looks for them.

    Attributes:
        path: the file that counts.
        current: whether it is what this hilbench would install, for that group.
        group: who gets the ports by it; None if it names none, or several, or, where udev looks, one that is not there.
        problems: what is wrong in it.
    """

    path: Path
    current: bool
    group: str | None
    problems: tuple[Problem, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Verified:
    """What ``udevadm verify`` said.

    Attributes:
        right: None if it was not run.
        what: in words.
    """

    right: bool | None
    what: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Checked:
    """How the rules stand on a machine.

    Attributes:
        installed: what is installed; None if nothing is.
        verified: what udev says of it; None if nothing is installed.
        fix: how a person puts them right, for the group that has the ports.
    """

    installed: Installed | None
    verified: Verified | None
    fix: str = INSTALL_BY

    @property
    def right(self) -> bool:
        """Whether they are installed as this hilbench has them, with nothing wrong in them."""
        found, verified = self.installed, self.verified
        return (
            found is not None and found.current and not found.problems and (not verified or verified.right is not False)
        )

    def as_data(self) -> dict[str, object]:
        """Return it as plain data."""
        found, verified = self.installed, self.verified
        return {
            "right": self.right,
            "path": str(found.path) if found else None,
            "current": found.current if found else None,
            "problems": [{"line": one.line, "what": one.what} for one in found.problems] if found else [],
            "udevadm_verify": {"right": verified.right, "what": verified.what} if verified else None,
        }

    def as_text(self) -> str:
        """Return it as lines for a person."""
        found, verified = self.installed, self.verified
        if found is None:
            return f"not installed; install them: {self.fix}"
        how = "" if found.current else f"not as this hilbench has them; put right by: {self.fix}"
        lines = [f"{found.path}: installed, {how or 'as this hilbench has them'}"]
        lines += [f"{found.path}:{one.line}: {one.what}" for one in found.problems]
        return "\n".join([*lines, verified.what] if verified else lines)


def rules_text(group: str = _SHIPPED_GROUP) -> str:
    """Return the rules, with the group that gets the ports.

    Raises:
        UsageError: no group can be called that.
        UnavailableError: they are not where they should be.
    """
    if not _GROUP_NAME.fullmatch(group):
        raise UsageError(f"'{group}' is no name of a group", where="--group")
    package = Path(hilbench.__file__).parent
    # In a wheel beside the code, in a checkout at its top.
    for path in (package / "data/udev" / RULES_NAME, package.parent / "udev" / RULES_NAME):
        with contextlib.suppress(OSError):
            return path.read_text(encoding="utf-8").replace(f'GROUP="{_SHIPPED_GROUP}"', f'GROUP="{group}"')
    raise UnavailableError("the udev rules are missing", where=str(package), hint="install hilbench again")


def port_group(host: Host) -> str:
    """Return the group that owns serial ports on a machine."""
    return next((group for group in _GROUPS if host.has_group(group)), _SHIPPED_GROUP)


def install_by(host: Host, group: str | None, directory: str | None = None) -> str:
    """Return how a person installs them for a group, None for whoever owns serial ports on this machine."""
    more = f" --directory {shlex.quote(directory)}" if directory is not None else ""
    return INSTALL_BY + more + (f" --group {group}" if group not in {None, port_group(host)} else "")


def group_to_install(host: Host, directory: str | None = None) -> str:
    """Return the group of the rules that are installed, where udev looks or in a folder, else who owns serial ports."""
    found = installed_rules(host, directory=directory)
    return found.group if found is not None and found.group is not None else port_group(host)


def check_rules(host: Host, group: str | None = None, directory: str | None = None) -> Checked:
    """Return how the rules stand, in one folder or where udev looks.

    Args:
        host: the machine.
        group: who is to get the ports; None for whoever gets them by what is installed.
        directory: the folder.

    Raises:
        UsageError: no group can be called that.
        UnavailableError: there is nothing to compare them with.
    """
    found = installed_rules(host, group, directory)
    verified = verify_rules(host, host.path(str(found.path))) if found is not None else None
    wanted = group or (found.group if found is not None else None)
    return Checked(installed=found, verified=verified, fix=install_by(host, wanted, directory))


def installed_rules(host: Host, group: str | None = None, directory: str | None = None) -> Installed | None:
    """Return what is installed, compared with what `rules_text` gives; None if nothing is. See `check_rules`."""
    for folder in (directory,) if directory is not None else _FOLDERS:
        path = f"{folder}/{RULES_NAME}"
        found = host.text(path)
        if found is not None:
            theirs = _group_of(found)
            if directory is None and theirs is not None and not host.has_group(theirs):
                theirs = None
            current = found == rules_text(group or theirs or port_group(host))
            return Installed(path=Path(path), current=current, group=theirs, problems=tuple(problems_of(found)))
    return None


def _group_of(text: str) -> str | None:
    """Return the group that rules name; None if they name none, or several, or one that cannot be."""
    named = {one.value for rule in parse_rules(text)[0] for one in rule.expressions if one.key == "GROUP"}
    return named.pop() if len(named) == 1 and all(map(_GROUP_NAME.fullmatch, named)) else None


def verify_rules(host: Host, path: Path) -> Verified:
    """Let udev itself look at a file, if it can."""
    version = _udev_version(host)
    if version is None:
        return Verified(right=None, what="udevadm verify: not run, there is no udevadm here")
    if version < _VERIFIES_SINCE:
        return Verified(right=None, what=f"udevadm verify: not run, systemd {version} cannot; {_VERIFIES_SINCE} can")
    ran = host.run(["udevadm", "verify", "--resolve-names=never", "--no-summary", str(path)])
    if ran is None:
        return Verified(right=None, what="udevadm verify: could not be run")
    if ran.code == 0:
        return Verified(right=True, what=f"udevadm verify of systemd {version}: nothing found")
    return Verified(right=False, what=" ".join(f"udevadm verify of systemd {version}: {ran.output}".split()))


def install_rules(directory: Path, text: str, print_by: str = "hilbench udev") -> Path | None:
    """Write the rules into a folder, all or nothing.

    Args:
        directory: the folder.
        text: the rules.
        print_by: the command that prints them, for whoever may not write there.

    Returns:
        Where the file that was there is kept, if another was.

    Raises:
        UnavailableError: they cannot be written.
    """
    target = directory / RULES_NAME
    try:
        before = target.read_text(encoding="utf-8", errors="replace") if target.exists() else None
        # On a disk that fills up meanwhile the rules that are there must stay: what can fail comes first.
        with tempfile.TemporaryDirectory(dir=directory, prefix=f".{RULES_NAME}-") as beside:
            written, copied = Path(beside) / "new", Path(beside) / "old"
            written.write_text(text, encoding="utf-8")
            written.chmod(0o644)
            kept = None
            if before is not None and before != text:
                shutil.copy2(target, copied, follow_symlinks=False)
                kept = copied.replace(target.with_name(f"{RULES_NAME}.old"))  # udev reads names that end in .rules
            written.replace(target)
    except OSError as error:
        raise _cannot_install(directory, error, print_by) from error
    return kept


def reload_rules(host: Host) -> str:
    """Have udev read its rules again and look at what is plugged in; return what was done, or is to be done."""
    if host.which("udevadm"):
        ran = [host.run(command) for command in _RELOAD]
        if all(one is not None and one.code == 0 for one in ran):
            return "udev has read them; what is plugged in has its access and its names"
    return f"udev could not be notified; run: {_RELOAD_BY}"


def _cannot_install(directory: Path, error: OSError, print_by: str) -> HilbenchError:
    if isinstance(error, FileNotFoundError):
        return UnavailableError("there is no such folder", where=str(directory), hint=f"sudo mkdir -p {directory}")
    if isinstance(error, PermissionError):
        hint = f"{print_by} | sudo tee {shlex.quote(str(directory / RULES_NAME))} >/dev/null && {_RELOAD_BY}"
        return UnavailableError("only root may write there", where=str(directory), hint=hint)
    return UnavailableError(f"cannot be written: {error.strerror or error}", where=str(directory))


def _udev_version(host: Host) -> int | None:
    if host.which("udevadm") is None:
        return None
    ran = host.run(["udevadm", "--version"])
    number = re.match(r"\d+", ran.output) if ran else None
    return int(number[0]) if number else None
