"""What make audit says about what it is answered."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from tests.setup.programs import put_program

ROOT = Path(__file__).resolve().parents[2]
PYTHON = '{"dependencies": [{"name": "a", "vulns": []}], "fixes": []}'
NPM = '{"auditReportVersion": 2, "vulnerabilities": {}}'
BAD_NPM = '{"auditReportVersion": 2, "vulnerabilities": {"b": {"severity": "high"}}}'
OFFLINE = '{"message": "request failed", "error": {"code": "ENOTFOUND"}}'


@pytest.mark.parametrize(
    ("python", "npm", "status", "said"),
    [
        ((PYTHON, 0), (NPM, 0), 0, "npm audit knows no vulnerabilities"),
        ((PYTHON, 0), (BAD_NPM, 1), 1, '"severity": "high"'),
        ((PYTHON, 1), (OFFLINE, 1), 1, "pip-audit knows vulnerabilities"),
        ((PYTHON, 0), (OFFLINE, 1), 2, "npm audit could not be asked"),
        (None, (NPM, 0), 2, "pip install pip-audit"),
    ],
)
def test_the_audit_tells_vulnerabilities_from_services_that_do_not_answer(
    tmp_path: Path,
    python: tuple[str, int] | None,
    npm: tuple[str, int],
    status: int,
    said: str,
) -> None:
    pip_audit = tmp_path / "missing"
    if python is not None:
        pip_audit = put_program(tmp_path, "pip-audit", f"echo '{python[0]}'; exit {python[1]}")
    asked = put_program(tmp_path, "npm", f"echo '{npm[0]}'; exit {npm[1]}")
    done = subprocess.run(
        [ROOT / "scripts/audit.sh", pip_audit, asked], cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == status, done.stdout + done.stderr
    assert said in done.stdout
