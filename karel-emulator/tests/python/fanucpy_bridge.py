"""Lets a test drive the real fanucpy client: one JSON request a line, one JSON answer a line.

{"robot": "a", "new": {options of Robot}}                     -> {"returned": null}
{"robot": "a", "call": "get_curpos", "arguments": {..}}       -> {"returned": [..]} or {"raised": "FanucError: .."}
"""

import importlib.metadata
import json
import sys

from fanucpy import Robot


def do(robots, request):
    name = request["robot"]
    if "new" in request:
        robots[name] = Robot(**request["new"])
        return None
    method = getattr(robots[name], request["call"])
    return method(**request["arguments"])


def main():
    robots = {}
    say({"version": importlib.metadata.version("fanucpy")})
    for line in sys.stdin:
        try:
            say({"returned": do(robots, json.loads(line))})
        except Exception as error:  # whatever the client raises is what the test wants to see
            say({"raised": f"{type(error).__name__}: {error}"})


def say(answer):
    print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
