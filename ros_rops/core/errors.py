# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Exceptions for a caller's mistake.

Bad *data* never raises past the pipeline: it becomes a `Status` and no transform.
"""


class RopsError(Exception):
    """Root of every exception that this package raises on purpose."""


class ParameterError(RopsError, ValueError):
    """A parameter is unknown, of the wrong type or out of its bounds; the text names it."""


class ShapeError(RopsError, ValueError):
    """An array handed in has the wrong shape or type; the text names it."""


class InputError(RopsError):
    """A file or recording cannot be read as what it claims to be; the text names it."""


class ViewError(RopsError):
    """A view holds too little to register (empty, all NaN, two points); the text says what."""


class ModelError(RopsError):
    """No surface comes of an object's views; the text says why."""


class KernelMissingError(RopsError, ImportError):
    """The compiled kernels are missing; the text says how to build them."""
