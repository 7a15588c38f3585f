"""A job of Windows: a process and all that it starts, ended together, whatever has become of their parents.

A process starts suspended, is put into the job and then goes on, so that nothing it starts can be outside. When the
job's last handle is closed, as when Blender itself ends, all that is in it ends too.
"""

from __future__ import annotations

import ctypes
import subprocess
import sys
from collections.abc import Sequence
from typing import Any

_EXTENDED_LIMITS = 9  # JobObjectExtendedLimitInformation
_KILL_ON_CLOSE = 0x2000  # JOB_OBJECT_LIMIT_KILL_ON_JOB_CLOSE
_SUSPENDED = 0x4  # CREATE_SUSPENDED
_ENDED = 1  # exit status of what is ended


class _BasicLimits(ctypes.Structure):
    """JOBOBJECT_BASIC_LIMIT_INFORMATION."""

    _fields_ = (
        ("per_process_time", ctypes.c_int64),
        ("per_job_time", ctypes.c_int64),
        ("flags", ctypes.c_uint32),
        ("least_working_set", ctypes.c_size_t),
        ("most_working_set", ctypes.c_size_t),
        ("most_processes", ctypes.c_uint32),
        ("affinity", ctypes.c_size_t),
        ("priority", ctypes.c_uint32),
        ("scheduling", ctypes.c_uint32),
    )


class _ExtendedLimits(ctypes.Structure):
    """JOBOBJECT_EXTENDED_LIMIT_INFORMATION."""

    _fields_ = (
        ("basic", _BasicLimits),
        ("io_counters", ctypes.c_uint64 * 6),
        ("process_memory", ctypes.c_size_t),
        ("job_memory", ctypes.c_size_t),
        ("peak_process_memory", ctypes.c_size_t),
        ("peak_job_memory", ctypes.c_size_t),
    )


class WindowsJob:
    """A job with one process and what that starts.

    system: has the functions of kernel32 and `NtResumeProcess`; left out, Windows'.
    """

    def __init__(self, system: Any = None) -> None:
        self._system = system or _windows()
        self._handle = self._system.CreateJobObjectW(None, None)
        limits = _ExtendedLimits()
        limits.basic.flags = _KILL_ON_CLOSE
        size = ctypes.sizeof(limits)
        if not self._handle or not self._system.SetInformationJobObject(
            self._handle, _EXTENDED_LIMITS, ctypes.byref(limits), size
        ):
            self.close()
            raise OSError("Windows made no job for the command.")

    def start(self, command: Sequence[str], **options: Any) -> subprocess.Popen[str]:
        """Start the command in the job. options: of `subprocess.Popen`.

        Raises OSError if it cannot be started or not be put into the job; it does not run then.
        """
        options["creationflags"] = options.get("creationflags", 0) | _SUSPENDED
        process = subprocess.Popen(command, **options)
        handle = int(process._handle)  # type: ignore[attr-defined]
        if not self._system.AssignProcessToJobObject(self._handle, handle):
            process.kill()
            process.wait()
            raise OSError("Windows did not put the command into its job.")
        self._system.NtResumeProcess(handle)
        return process

    def end(self) -> None:
        """End all that is in the job, at once."""
        if self._handle:
            self._system.TerminateJobObject(self._handle, _ENDED)

    def close(self) -> None:
        """Let the job go; what is left in it ends."""
        if self._handle:
            self._system.CloseHandle(self._handle)
        self._handle = None


class _Windows:
    """The functions of Windows with the types of what they take."""

    def __init__(self) -> None:
        if sys.platform == "win32":
            kernel = ctypes.WinDLL("kernel32", use_last_error=True)
            for name, kinds in _SIGNATURES.items():
                function = getattr(kernel, name)
                function.argtypes, function.restype = kinds
                setattr(self, name, function)
            resume = ctypes.WinDLL("ntdll").NtResumeProcess
            resume.argtypes, resume.restype = (ctypes.c_void_p,), ctypes.c_int32
            self.NtResumeProcess = resume


_SIGNATURES: dict[str, tuple[tuple[Any, ...], Any]] = {
    "CreateJobObjectW": ((ctypes.c_void_p, ctypes.c_wchar_p), ctypes.c_void_p),
    "SetInformationJobObject": ((ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p, ctypes.c_uint32), ctypes.c_int),
    "AssignProcessToJobObject": ((ctypes.c_void_p, ctypes.c_void_p), ctypes.c_int),
    "TerminateJobObject": ((ctypes.c_void_p, ctypes.c_uint), ctypes.c_int),
    "CloseHandle": ((ctypes.c_void_p,), ctypes.c_int),
}


def _windows() -> Any:
    return _Windows()
