#include "cli/commands.h"

namespace hgg {

void addCommands(CLI::App& app, Action& action) {
  for (const auto add : {addRun, addReplay, addExport, addAlign, addMerge, addInfo, addPlan, addImport, addQuery}) {
    add(app, action);
  }
}

}  // namespace hgg
