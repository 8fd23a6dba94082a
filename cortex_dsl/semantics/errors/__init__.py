"""Every finding of this stage, declared once: a module for each family, each of its rows a name of this package."""

from cortex_dsl.semantics.errors.behaviours import *  # noqa: F403
from cortex_dsl.semantics.errors.choices import *  # noqa: F403
from cortex_dsl.semantics.errors.composing import *  # noqa: F403
from cortex_dsl.semantics.errors.definitions import *  # noqa: F403
from cortex_dsl.semantics.errors.driving import *  # noqa: F403
from cortex_dsl.semantics.errors.feasibility import *  # noqa: F403
from cortex_dsl.semantics.errors.monitors import *  # noqa: F403
from cortex_dsl.semantics.errors.names import *  # noqa: F403
from cortex_dsl.semantics.errors.placing import *  # noqa: F403
from cortex_dsl.semantics.errors.roads import *  # noqa: F403
from cortex_dsl.semantics.errors.running import *  # noqa: F403
from cortex_dsl.semantics.errors.statements import *  # noqa: F403
from cortex_dsl.semantics.errors.temporal import *  # noqa: F403
from cortex_dsl.semantics.errors.units import *  # noqa: F403
from cortex_dsl.semantics.errors.values import *  # noqa: F403
