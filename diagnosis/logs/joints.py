"""Names of joints that logs tell, which must be the same in all of them."""

from __future__ import annotations

from collections.abc import Sequence

from flexhex.diagnosis.logs.log import Log
from flexhex.fmus.common.errors import LogError


def refuse_other_joints(logs: Sequence[Log]) -> None:
    """LogError where two logs have other joints, or the same ones in another order: axes are
    columns."""
    named = [log for log in logs if log.joints]
    for log in named[1:]:
        if log.joints != named[0].joints:
            raise LogError(
                f"{log.name}: its joints are {', '.join(log.joints)}; those of {named[0].name} are"
                f" {', '.join(named[0].joints)}: write the messages of both in one order"
            )
