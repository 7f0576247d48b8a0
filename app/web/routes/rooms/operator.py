"""Checks that a request comes from the operator."""

import hmac

from fastapi import Depends, Request
from fastapi.security import HTTPBearer

from plinko.app.errors import TokenError
from plinko.app.web.services import Services
from plinko.app.web.tokens import bearer_of, check_bearer

# This only documents the scheme for OpenAPI; `plinko.app.web.tokens` checks the token.
Token = Depends(
    HTTPBearer(
        scheme_name="operatorToken", description="`PLINKO_OPERATOR_TOKEN`.", auto_error=False
    )
)


def check_operator(request: Request, server: Services, what: str) -> None:
    """Raise NoTokenError or TokenError unless the request has the operator's token.

    `what` names the operation for the message: 'halting a room'.
    """
    token = server.settings.operator_token
    if not token:
        raise TokenError(
            f"{what} needs the operator's token, but this server was started without one: "
            "set PLINKO_OPERATOR_TOKEN",
            field="authorization",
        )
    check_bearer(request.headers.get("authorization"), token, "of the operator")


def is_operator(request: Request, server: Services) -> bool:
    token = server.settings.operator_token
    shown = bearer_of(request.headers.get("authorization"))
    return bool(token and shown) and hmac.compare_digest(str(shown).encode(), token.encode())
