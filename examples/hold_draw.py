"""Hold a prize draw with exact odds: one ball per name, and a file that anybody can check.

    plinko seeds triangle-8 --draw 1,0,0,0,9999,0,0,0,0 -o draw.json
    python hold_draw.py draw.json session.json Ada Bob
    plinko verify session.json

The program opens a room with the draw, drops the balls in one fair session, and ends the session.
`--server` is the address of the game. The program first prints the room's id: show the audience
`stage.html?room=ROOM`, then press Enter to drop the balls.
"""
# pip install httpx

import argparse
import hashlib
import json
import secrets

import httpx


def once(members):
    """The members of a JSON object; refuses a key given twice, of which readers keep either."""
    found = dict(members)
    if len(found) < len(members):
        keys = [key for key, _ in members]
        key = next(key for key in keys if keys.count(key) > 1)
        raise SystemExit(f"{key!r}: the key is given twice")
    return found


def asked(client, method, path, token=None, **body):
    """Send a request and return the JSON of the answer; exit with the server's error if any."""
    headers = {"Authorization": f"Bearer {token}"} if token else {}
    answer = client.request(method, f"/api/v1/{path}", json=body or None, headers=headers)
    if answer.is_error:
        raise SystemExit(answer.json()["detail"])
    return answer.json()


def hold(client, draw, names, secret):
    """Hold the draw; return the session's export with the replies received before its end."""
    room = asked(client, "POST", "rooms", **draw)
    print(f"room {room['id']}, draw {room['draw']['digest']}")
    # The room's token lets the session give names to its balls.
    commitment = hashlib.sha256(secret).hexdigest()
    begun = asked(client, "POST", "sessions", room["token"], room=room["id"], commitment=commitment)
    print(f"the server has committed to {begun['statement']['server_commitment']}")
    input("Press Enter to drop the balls.")
    place, token = f"sessions/{begun['session']}", begun["token"]
    asked(client, "POST", f"{place}/opening", token, seed=secret.hex())
    heard = []
    for name in names:
        drops = f"rooms/{room['id']}/drops?wait=1"
        drop = asked(client, "POST", drops, token, session=begun["session"], name=name)
        heard.append(drop["receipt"])
        landed = drop["landed"]
        print(f"{name}: {landed.get('label') or 'bin ' + str(landed['bin'] + 1)}")
    asked(client, "POST", f"{place}/end", token)
    given = {name: begun[name] for name in ("statement", "signature")}
    export = asked(client, "GET", f"{place}/export", token)
    return {**export, "heard": heard, "heard_session": given}


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--server", default="http://127.0.0.1:8000")
    parser.add_argument("draw", help="the file that plinko seeds --draw has written")
    parser.add_argument("session", help="the file to write")
    parser.add_argument("names", nargs="+")
    options = parser.parse_args()
    with open(options.draw, "rb") as file:
        draw = json.loads(file.read(), object_pairs_hook=once)  # in any encoding of Unicode
    with httpx.Client(base_url=options.server, timeout=60.0) as client:
        export = hold(client, draw, options.names, secrets.token_bytes(32))
    with open(options.session, "w", encoding="utf-8") as file:
        json.dump(export, file)
    print(f"{options.session}: check it with plinko verify, or on verify.html")


if __name__ == "__main__":
    main()
