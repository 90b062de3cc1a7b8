"""What a visitor does passes through few files, so that it can be followed in the code."""

import pytest
from measure_flows import FLOWS


@pytest.mark.parametrize("name", FLOWS)
def test_a_flow_enters_few_files_of_the_page(name):
    run, most = FLOWS[name]
    entered = run()
    assert "model/queue.py" in entered and len(entered) <= most, sorted(entered)
