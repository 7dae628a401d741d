#pragma once

#include "cli/common.h"

namespace hgg {

// Each adds its command to `app`, with options of its own. When the command line asks for it, `action` becomes what it
// does; `action` must be there until the command line is parsed. A new command is a file here, its declaration below,
// and its name in addCommands().
void addRun(CLI::App& app, Action& action);
void addReplay(CLI::App& app, Action& action);
void addExport(CLI::App& app, Action& action);
void addAlign(CLI::App& app, Action& action);
void addInfo(CLI::App& app, Action& action);
void addMerge(CLI::App& app, Action& action);
void addPlan(CLI::App& app, Action& action);
void addImport(CLI::App& app, Action& action);
void addQuery(CLI::App& app, Action& action);

/// All of them, in the order of --help.
void addCommands(CLI::App& app, Action& action);

}  // namespace hgg
