# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
# The typed faces beside this file are what the rest of the package calls.
from typing import Any

def __getattr__(name: str) -> Any: ...
