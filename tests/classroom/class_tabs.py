"""A class by the protocol alone: tabs of students and of the lecturer, and what is done in them."""

import http.client
import re

from protocol import Client
from serving import STARTS_WITHIN_S
from waiting import wait_until


def asked(url, path, cookie=""):
    """Status and cookies of the answer to a request."""
    connection = http.client.HTTPConnection(url.removeprefix("http://"), timeout=20)
    connection.request("GET", path, headers={"Cookie": cookie, "Sec-Fetch-Site": "same-origin"})
    answer = connection.getresponse()
    answer.read()
    return answer.status, answer.headers.get_all("Set-Cookie") or []


class Tab(Client):
    """With the address of its links."""

    def __init__(self, url, cookie):
        self.url, self.cookie = url, cookie
        super().__init__(url, cookie=cookie)
        self.ready(STARTS_WITHIN_S)  # it may come to a process that is only just begun
        self.address = wait_until(lambda: self.found(r'href="(/touch/[^/]+)/point/'))

    def follow(self, what):
        return asked(self.url, f"{self.address}/{what}", self.cookie)[0]

    def found(self, pattern):
        return next((found[1] for html in list(self.html.values()) if (found := re.search(pattern, html))), None)

    def shows(self, text):
        return any(text in html for html in list(self.html.values()))

    @property
    def E(self):
        found = re.search(r"E ([\d.]+) px", self.status)
        return found and found[1]


def lecturers_cookie(url, secret):
    return "; ".join(one.split(";")[0] for one in asked(url, f"/lecturer/{secret}")[1])


def ask_class(lecturer, students):
    lecturer.follow("lesson/begin,tour")
    wait_until(lambda: lecturer.shows("data-screen"))
    while not lecturer.shows("class/ask"):
        before = lecturer.found(r'data-screen="([^"]+)"')
        lecturer.follow("lesson/next")
        wait_until(lambda before=before: lecturer.found(r'data-screen="([^"]+)"') != before)
    lecturer.follow("class/ask")
    for k, tab in enumerate(students):
        wait_until(lambda tab=tab: tab.shows("The class is asked"))
        assert tab.follow(f"lesson/choose,{k}") == 204
    wait_until(lambda: lecturer.shows("<b>2</b> of 2 answered"))
    lecturer.follow("class/reveal")
    for tab in (*students, lecturer):
        wait_until(lambda tab=tab: tab.shows("1 of 2 are right"))
    lecturer.follow("class/close")
    lecturer.follow("lesson/leave")
    wait_until(lambda: not any(tab.shows("data-screen") for tab in (*students, lecturer)))
