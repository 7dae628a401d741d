#include "publish/command_desk.h"

#include <gtest/gtest.h>

namespace hgg::command_desk_test {
namespace {

Command commandOf(std::int64_t id, CommandKind kind = CommandKind::kPublishTraversability) {
  Command command;
  command.client = "nav", command.request_id = id, command.kind = kind;
  return command;
}

CommandReply done(const Command& command) {
  CommandReply reply = refusal(command, "done");
  reply.ok = true;
  return reply;
}

TEST(CommandDesk, ARepeatedCommandIsCarriedOutOnceAndAnsweredEachTime) {
  CommandDesk desk;
  EXPECT_TRUE(desk.admit(commandOf(1)).is_accepted);
  const auto again = desk.admit(commandOf(1));
  EXPECT_FALSE(again.is_accepted);
  EXPECT_FALSE(again.reply.has_value()) << "it is answered when it is done";
  desk.answered(done(commandOf(1)));
  const auto later = desk.admit(commandOf(1));
  EXPECT_FALSE(later.is_accepted);
  ASSERT_TRUE(later.reply.has_value());
  EXPECT_TRUE(later.reply->ok);
  Command other = commandOf(1);
  other.client = "viewer";
  EXPECT_TRUE(desk.admit(other).is_accepted) << "ids are each client's own";
}

TEST(CommandDesk, WhatIsNotSupportedIsRefusedByName) {
  CommandDesk desk;
  std::int64_t id = 0;
  for (const auto& [kind, word] :
       {std::pair(CommandKind::kSave, "SAVE"), std::pair(CommandKind::kReset, "RESET"),
        std::pair(CommandKind::kResendAll, "RESEND_ALL"), std::pair(CommandKind::kPublishGeometry, "PUBLISH_GEOMETRY"),
        std::pair(static_cast<CommandKind>(99), "99"), std::pair(static_cast<CommandKind>(0), "0"),
        std::pair(static_cast<CommandKind>(-3), "-3")}) {
    const auto admission = desk.admit(commandOf(++id, kind));
    EXPECT_FALSE(admission.is_accepted);
    ASSERT_TRUE(admission.reply.has_value()) << word;
    EXPECT_FALSE(admission.reply->ok);
    EXPECT_EQ(admission.reply->request_id, id);
    EXPECT_EQ(admission.reply->client, "nav");
    EXPECT_TRUE(admission.reply->text.starts_with(word)) << admission.reply->text;
  }
}

TEST(CommandDesk, NoMoreWaitThanItCanHoldAndOneTurnedAwayMayComeAgain) {
  CommandDesk desk;
  const auto most = static_cast<std::int64_t>(CommandDesk::kMostWaiting);
  for (std::int64_t id = 0; id < most; ++id) {
    EXPECT_TRUE(desk.admit(commandOf(id)).is_accepted);
  }
  const auto turned_away = desk.admit(commandOf(most));
  EXPECT_FALSE(turned_away.is_accepted);
  ASSERT_TRUE(turned_away.reply.has_value());
  EXPECT_NE(turned_away.reply->text.find("later"), std::string::npos);
  desk.answered(done(commandOf(0)));
  EXPECT_TRUE(desk.admit(commandOf(most)).is_accepted);
}

TEST(CommandDesk, ForgetsTheOldestAnswersOnly) {
  CommandDesk desk;
  const auto most = static_cast<std::int64_t>(CommandDesk::kMostRemembered);
  for (std::int64_t id = 0; id <= most; ++id) {
    EXPECT_TRUE(desk.admit(commandOf(id)).is_accepted);
    desk.answered(done(commandOf(id)));
  }
  EXPECT_FALSE(desk.admit(commandOf(1)).is_accepted);
  EXPECT_TRUE(desk.admit(commandOf(0)).is_accepted);
}

}  // namespace
}  // namespace hgg::command_desk_test
