"""What only who runs the server may ask for."""

from fastapi import Request

from app.errors import TokenError
from app.web.services import Services
from app.web.tokens import check_bearer


def check_operator(request: Request, server: Services, what: str) -> None:
    """Raise NoTokenError or TokenError unless the request is that of who runs the server."""
    token = server.settings.operator_token
    if not token:
        raise TokenError(
            f"{what} with the operator's token, and this server was started without one: "
            "set PLINKO_OPERATOR_TOKEN",
            field="authorization",
        )
    check_bearer(request.headers.get("authorization"), token, "of the operator")
