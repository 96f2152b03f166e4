"""Scenario files: read, checked with messages for a user, written back, and described."""

from parkproof.scenario_file.read import GainsFile as GainsFile
from parkproof.scenario_file.read import read_gains_file as read_gains_file
from parkproof.scenario_file.read import read_scenario as read_scenario
from parkproof.scenario_file.read import scenario_from_dict as scenario_from_dict
from parkproof.scenario_file.schema import scenario_schema as scenario_schema
from parkproof.scenario_file.schema import schema_text as schema_text
from parkproof.scenario_file.templates import SPECIFICATIONS as SPECIFICATIONS
from parkproof.scenario_file.templates import TEMPLATES as TEMPLATES
from parkproof.scenario_file.templates import template as template
from parkproof.scenario_file.write import resolved as resolved
from parkproof.scenario_file.write import to_toml as to_toml
