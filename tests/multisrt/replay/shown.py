"""A page in a browser, opened from a file, as a user does."""

import time

DESKTOP, PHONE = {"width": 1300, "height": 850}, {"width": 390, "height": 844}
SETTLED = "!replay.player.isWaiting && replay.player.isComplete"
BELOW = "document.querySelector('.view .below').toDataURL()"
PICTURE = "[...document.querySelectorAll('.view canvas')].map((c) => c.toDataURL()).join()"


class Shown:
    """A page that is open, and what went wrong on it."""

    def __init__(self, page, url):
        self.page, self.url = page, url
        self.errors: list[str] = []
        self.asked: list[str] = []
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        page.on("console", self.hear)
        page.on("request", lambda request: self.asked.append(request.url))

    def hear(self, message):
        if message.type in ("error", "warning"):
            self.errors.append(message.text)

    def open(self, address=""):
        self.page.goto("about:blank")
        self.page.goto(self.url + address)
        self.until("!!window.replay")
        self.settle()
        return self

    def settle(self):
        self.until(SETTLED)

    def until(self, expression, timeout_s=20.0):
        # The page's policy forbids what wait_for_function does: to evaluate text within it.
        late = time.monotonic() + timeout_s
        while not self.page.evaluate(expression):
            assert time.monotonic() < late, expression
            self.page.wait_for_timeout(20)

    def text(self, selector):
        return self.page.locator(selector).text_content()

    def value(self, expression):
        return self.page.evaluate(expression)


def click(page, x, y):
    """Click on a place in the world."""
    view = "replay.player.views[0]"
    px, py, ratio = page.value(f"[{view}.x({x}), {view}.y({y}), {view}.camera.ratio]")
    page.page.locator(".view .top").first.click(position={"x": px / ratio, "y": py / ratio})
