# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
A browser without a window, steered by JSON lines: Chromium as QtWebEngine has it.

Run as a process of its own. A line in is one command (`COMMANDS`), a line out its answer.
Requests for anything but a file or data are refused and counted. The environment (`browser`) says
that there is no screen and that the GPU is made of software.
"""

import json
import os
import sys

from PySide6.QtCore import QEvent, QEventLoop, QPoint, QPointF, QSize, Qt, QTimer, QUrl
from PySide6.QtGui import QInputDevice, QMouseEvent, QPointingDevice, QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWebEngineCore import (
    QWebEnginePage, QWebEngineProfile, QWebEngineScript, QWebEngineUrlRequestInterceptor)
from PySide6.QtWebEngineWidgets import QWebEngineView
from PySide6.QtWidgets import QApplication

BUTTONS = {'left': Qt.MouseButton.LeftButton, 'right': Qt.MouseButton.RightButton}


class Refuser(QWebEngineUrlRequestInterceptor):
    """Lets nothing through but files and data."""

    def __init__(self):
        super().__init__()
        self.requests = []

    def interceptRequest(self, info):  # noqa: N802
        url = info.requestUrl()
        if url.scheme() not in ('data', 'blob'):
            self.requests.append(url.toString())
        if url.scheme() not in ('file', 'data', 'blob'):
            info.block(True)


class Page(QWebEnginePage):
    """A page whose console is kept."""

    def __init__(self, profile):
        super().__init__(profile)
        self.console = []

    def javaScriptConsoleMessage(self, level, message, line, source):  # noqa: N802
        self.console.append(f'{level.name}: {message} ({line})')


class Browser:
    """The commands."""

    def __init__(self):
        self.refuser = Refuser()
        self.profile = QWebEngineProfile()
        self.profile.setUrlRequestInterceptor(self.refuser)
        self.view = QWebEngineView()
        self.finger = QTest.createTouchDevice(QInputDevice.DeviceType.TouchScreen)
        self.page = None

    def visit(self, path, width, height, before=''):
        """Load a file in a window of this size, a script before it; tell whether it came."""
        self.refuser.requests.clear()
        self.page = Page(self.profile)
        script = QWebEngineScript()
        script.setInjectionPoint(QWebEngineScript.InjectionPoint.DocumentCreation)
        script.setWorldId(QWebEngineScript.ScriptWorldId.MainWorld)
        script.setSourceCode(before)
        self.page.scripts().insert(script)
        self.view.setPage(self.page)
        self.view.resize(QSize(width, height))
        self.view.show()
        loop, came = QEventLoop(), []
        self.page.loadFinished.connect(lambda ok: (came.append(ok), loop.quit()))
        self.page.load(QUrl.fromLocalFile(path))
        QTimer.singleShot(60000, loop.quit)
        loop.exec()
        self.wait(40)
        return bool(came and came[0])

    def wait(self, ms):
        """Let time pass."""
        loop = QEventLoop()
        QTimer.singleShot(ms, loop.quit)
        loop.exec()

    def js(self, code):
        """Return what a script's last expression is, by way of JSON."""
        loop, answer = QEventLoop(), []
        self.page.runJavaScript(
            f'JSON.stringify((() => {{ {code} }})())',
            lambda value: (answer.append(value), loop.quit()))
        QTimer.singleShot(30000, loop.quit)
        loop.exec()
        return json.loads(answer[0]) if answer and answer[0] else None

    def grab(self, path):
        """Save what is shown as PNG."""
        self.wait(120)
        return self.view.grab().save(path)

    def drag(self, x, y, dx, dy, button='left', steps=5):
        """Press, move in steps, release: as a hand does."""
        widget, held = self.view.focusProxy(), BUTTONS[button]
        self._mouse(QEvent.Type.MouseButtonPress, widget, x, y, held, held)
        for k in range(1, steps + 1):
            self._mouse(QEvent.Type.MouseMove, widget, x + dx * k / steps, y + dy * k / steps,
                        Qt.MouseButton.NoButton, held)
            self.wait(15)
        self._mouse(QEvent.Type.MouseButtonRelease, widget, x + dx, y + dy, held,
                    Qt.MouseButton.NoButton)
        self.wait(25)

    def _mouse(self, kind, widget, x, y, button, buttons):
        at = QPointF(x, y)
        QApplication.sendEvent(widget, QMouseEvent(
            kind, at, widget.mapToGlobal(at), button, buttons, Qt.KeyboardModifier.NoModifier))

    def wheel(self, x, y, delta):
        """Turn the wheel over a place."""
        widget, at = self.view.focusProxy(), QPointF(x, y)
        QApplication.sendEvent(widget, QWheelEvent(
            at, widget.mapToGlobal(at), QPoint(), QPoint(0, delta), Qt.MouseButton.NoButton,
            Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase, False,
            device=QPointingDevice.primaryPointingDevice()))
        self.wait(25)

    def fingers(self, begin, end, steps=5):
        """Put fingers down at places, move them to others, lift them."""
        widget = self.view.focusProxy()

        def at(share):
            return [
                QPoint(round(a + (c - a) * share), round(b + (d - b) * share))
                for (a, b), (c, d) in zip(begin, end, strict=True)]

        touch = QTest.touchEvent(widget, self.finger)
        for k, point in enumerate(at(0)):
            touch.press(k, point, widget)
        touch.commit()
        for step in range(1, steps + 1):
            touch = QTest.touchEvent(widget, self.finger)
            for k, point in enumerate(at(step / steps)):
                touch.move(k, point, widget)
            touch.commit()
            self.wait(15)
        touch = QTest.touchEvent(widget, self.finger)
        for k, point in enumerate(at(1)):
            touch.release(k, point, widget)
        touch.commit()
        self.wait(25)

    def key(self, name):
        """Press a key."""
        QTest.keyClick(self.view.focusProxy(), getattr(Qt.Key, f'Key_{name}'))
        self.wait(25)

    def console(self):
        """Return what the page wrote on its console."""
        return self.page.console

    def requests(self):
        """Return what the page asked for."""
        return self.refuser.requests


def answer(content):
    """Write a line of JSON."""
    sys.stdout.write(json.dumps(content) + '\n')
    sys.stdout.flush()


def main():
    """Do what the lines say until there are no more."""
    app = QApplication(sys.argv[:1])
    browser = Browser()
    answer('ready')
    for line in sys.stdin:
        name, arguments = json.loads(line)
        answer(getattr(browser, name)(**arguments))
    browser.page = None
    app.quit()
    os._exit(0)  # Qt takes seconds to part from its processes


if __name__ == '__main__':
    main()
