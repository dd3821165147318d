#!/usr/bin/env python3
"""kills.py PROGRAM [COUNT [SEED]]: kills a server COUNT times (300) while sessions change, and compares each session's state document after each.

A change that was answered is there after the kill; one that was on its way is there whole or not at all. Beside CI: a life takes about a second.
"""
import http.client, json, os, random, signal, subprocess, sys, tempfile, threading, time

TOKEN = "the-same-token-in-every-life"
SESSIONS = 6


class Server:
    def __init__(self, program, folder):
        self.program, self.folder, self.port, self.process, self.lives = program, folder, 0, None, 0

    def start(self):
        self.lives += 1
        ready = os.path.join(self.folder, f"ready-{self.lives}.json")
        self.process = subprocess.Popen(
            [self.program, "serve", "torus:12", "cylinder:12x8x6", "--device", "native", "--port", str(self.port), "--token", TOKEN,
             "--state-dir", os.path.join(self.folder, "state"), "--ready-file", ready],
            stdout=subprocess.DEVNULL, stderr=open(os.path.join(self.folder, "log"), "a"), env={**os.environ, "TMPDIR": self.folder, "ISOSTRATA_CACHE": "off"})
        until = time.monotonic() + 60
        while not os.path.exists(ready):
            if self.process.poll() is not None or time.monotonic() > until:
                sys.exit("the server does not answer: " + open(os.path.join(self.folder, "log")).read()[-2000:])
            time.sleep(0.01)
        self.port = json.load(open(ready))["port"]

    def kill(self):
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()

    def ask(self, method, path, body=None):
        line = http.client.HTTPConnection("127.0.0.1", self.port, timeout=30)
        line.request(method, "/api/v1/" + path, json.dumps(body) if body is not None else None,
                     {"Authorization": "Bearer " + TOKEN, "Content-Type": "application/json"})
        answer = line.getresponse()
        text = answer.read()
        if answer.status >= 300:
            raise RuntimeError(f"{method} {path}: {answer.status} {text[:300]}")
        return json.loads(text) if text else None


def document(server, session):
    """The state but for its revision, which also counts what nobody has asked for."""
    state = server.ask("GET", f"sessions/{session}/state")
    state.pop("revision", None)
    return state


def changes(rng):
    """A merge patch of the state, of one kind or another."""
    number = lambda lower, upper: round(rng.uniform(lower, upper), 6)
    return rng.choice([
        lambda: {"camera": {"eye": {"x": number(2, 4), "y": number(2, 4), "z": number(2, 4)}}},
        lambda: {"background": {"r": number(0, 1), "g": number(0, 1), "b": number(0, 1)}},
        lambda: {"annotations": {"axes": rng.random() < 0.5, "legend": rng.random() < 0.5}},
        lambda: {"clipPlanes": [{"normal": {"z": -1}, "offset": number(-1, 0)}]},
    ])()


class Hand(threading.Thread):
    """Changes one session again and again; knows the last state that was answered, and the patch that was not."""

    def __init__(self, server, session, seed):
        super().__init__()
        self.server, self.session, self.rng = server, session, random.Random(seed)
        self.known, self.on_its_way, self.done = document(server, session), None, 0

    def run(self):
        try:
            while True:
                self.on_its_way = changes(self.rng)
                self.server.ask("PATCH", f"sessions/{self.session}/state", self.on_its_way)
                answered = document(self.server, self.session)
                self.known, self.on_its_way = answered, None
                self.done += 1
        except (OSError, http.client.HTTPException):
            return  # the kill


def main():
    program, count = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 300
    seed = int(sys.argv[3]) if len(sys.argv) > 3 else random.randrange(1 << 30)
    rng, wrong, exact, whole, changed = random.Random(seed), 0, 0, 0, 0
    print(f"{count} kills, seed {seed}", flush=True)
    with tempfile.TemporaryDirectory(prefix="isostrata-kills-", ignore_cleanup_errors=True) as folder:
        server = Server(program, folder)
        server.start()
        ids = [s["id"] for s in server.ask("GET", "datasets")["datasets"]]
        sessions = [server.ask("POST", "sessions", {"dataset": ids[i % len(ids)]})["id"] for i in range(SESSIONS)]
        for kill in range(count):
            hands = [Hand(server, session, rng.random()) for session in sessions]
            for hand in hands:
                hand.start()
            time.sleep(rng.uniform(0.0, 0.4))
            server.kill()
            for hand in hands:
                hand.join()
            server.start()
            for hand in hands:
                changed += hand.done
                now = document(server, hand.session)
                if now == hand.known:
                    exact += 1
                    continue
                rest = lambda state: {key: value for key, value in state.items() if key not in (hand.on_its_way or {})}
                if hand.on_its_way is not None and rest(now) == rest(hand.known):  # it was taken before the kill: then doing it again changes nothing
                    server.ask("PATCH", f"sessions/{hand.session}/state", hand.on_its_way)
                    if document(server, hand.session) == now:
                        whole += 1
                        continue
                wrong += 1
                print(f"kill {kill}, session {hand.session}: {json.dumps(now)}\n  expected {json.dumps(hand.known)}\n  on its way {hand.on_its_way}", flush=True)
            if (kill + 1) % 50 == 0:
                print(f"{kill + 1} kills: {changed} changes answered; {exact} documents equal, {whole} with the change on its way, {wrong} wrong", flush=True)
        server.process.terminate()
        server.process.wait()
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
