// The folder of keys: whom it names, and what it refuses.
#include "server/keys_folder.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zmq.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <utility>

#include "lattice/refused.h"
#include "server/key_file.h"

namespace lappet {
namespace {

namespace fs = std::filesystem;

std::pair<std::string, std::string> new_pair() {
  std::array<char, kKeyLength + 1> open{}, secret{};
  EXPECT_EQ(zmq_curve_keypair(open.data(), secret.data()), 0);
  return {open.data(), secret.data()};
}

class KeysFolderTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "keys-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    fs::create_directory(folder_ / "users");
    const auto [open, secret] = new_pair();
    write("server.key", "public = " + open + "\nsecret = " + secret + "\n", 0600);
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const std::string& name, const std::string& text, mode_t mode = 0644) {
    std::ofstream(folder_ / name) << text;
    ASSERT_EQ(::chmod((folder_ / name).c_str(), mode), 0);
  }
  // Writes a user's file; its public key.
  std::string allow(const std::string& name, const std::string& rest) {
    const std::string key = new_pair().first;
    write("users/" + name + ".pub", "public = " + key + "\n" + rest);
    return key;
  }
  std::string refusal() {
    try {
      const KeysFolder folder(folder_.string());
    } catch (const RefusedError& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
};

TEST_F(KeysFolderTest, AUserHasARoleAndQuotas) {
  const std::string anna = allow("anna", "role = author\nmemory_gib = 1.5\nthreads = 3\n");
  const std::string root = allow("r.o-o_t9", "# all of it\n\n  role=admin\nsessions = 0\nseconds = 60\n");
  const KeysFolder folder(folder_.string() + "//");
  const User* user = folder.with_key(anna);
  ASSERT_NE(user, nullptr);
  EXPECT_EQ(user->name, "anna");
  EXPECT_EQ(user->role, Role::kAuthor);
  EXPECT_EQ(user->quotas.memory_gib, 1.5);
  EXPECT_EQ(user->quotas.threads, 3);
  EXPECT_FALSE(user->quotas.sessions);
  user = folder.with_key(root);
  ASSERT_NE(user, nullptr);
  EXPECT_EQ(user->name, "r.o-o_t9");
  EXPECT_EQ(user->role, Role::kAdmin);
  EXPECT_EQ(user->quotas.sessions, 0);
  EXPECT_EQ(user->quotas.seconds, 60.0);
  EXPECT_EQ(folder.with_key(new_pair().first), nullptr);
}

TEST_F(KeysFolderTest, WhatChangesIsReadAgain) {
  const std::string anna = allow("anna", "role = follower\n");
  KeysFolder folder(folder_.string());
  const std::string bert = allow("bert", "role = author\n");
  EXPECT_EQ(folder.with_key(bert), nullptr);
  folder.refresh();
  EXPECT_NE(folder.with_key(bert), nullptr);
  write("users/anna.pub", "public = " + anna + "\nrole = admin\n");
  folder.refresh();
  ASSERT_NE(folder.with_key(anna), nullptr);
  EXPECT_EQ(folder.with_key(anna)->role, Role::kAdmin);
  fs::remove(folder_ / "users/anna.pub");
  folder.refresh();
  EXPECT_EQ(folder.with_key(anna), nullptr);
  EXPECT_NE(folder.with_key(bert), nullptr);
}

TEST_F(KeysFolderTest, AFileThatIsWrongLaterIsNoUser) {
  const std::string anna = allow("anna", "role = author\n");
  const std::string bert = allow("bert", "role = author\n");
  KeysFolder folder(folder_.string());
  write("users/anna.pub", "public = " + anna + "\nrole = author\nrole = admin\n");
  write("users/copy.pub", "public = " + bert + "\nrole = admin\n");
  folder.refresh();
  EXPECT_EQ(folder.with_key(anna), nullptr);
  EXPECT_EQ(folder.with_key(bert), nullptr) << "of two users with one key neither is let in";
  fs::remove(folder_ / "users/copy.pub");
  folder.refresh();
  EXPECT_NE(folder.with_key(bert), nullptr);
}

TEST_F(KeysFolderTest, NobodyIsKnownWhileTheFolderIsOpenToOthers) {
  const std::string anna = allow("anna", "role = author\n");
  KeysFolder folder(folder_.string());
  ASSERT_EQ(::chmod(folder_.c_str(), 0755), 0);
  folder.refresh();
  EXPECT_EQ(folder.with_key(anna), nullptr);
  ASSERT_EQ(::chmod(folder_.c_str(), 0700), 0);
  folder.refresh();
  EXPECT_NE(folder.with_key(anna), nullptr);
}

TEST_F(KeysFolderTest, WhatIsWrongIsNamedWithItsLine) {
  allow("anna", "\n\ncolor = red\n");
  EXPECT_NE(refusal().find("anna.pub', line 4: 'color' is not known here"), std::string::npos) << refusal();
  allow("anna", "role = author\nthreads = many\n");
  EXPECT_NE(refusal().find("line 3: 'threads' is 'many'; it must be 1 to 1024"), std::string::npos) << refusal();
  allow("anna", "role = author\nseconds = nan\n");
  EXPECT_NE(refusal().find("line 3: 'seconds'"), std::string::npos) << refusal();
  allow("anna", "role = author\nrole = admin\n");
  EXPECT_NE(refusal().find("line 3: 'role' is there twice"), std::string::npos) << refusal();
  write("users/anna.pub", "role = author\n");
  EXPECT_NE(refusal().find("no line 'public"), std::string::npos) << refusal();
  write("users/anna.pub", std::string("public = ") + std::string(40, '~') + "\nrole = author\n");
  EXPECT_NE(refusal().find("40 characters of Z85"), std::string::npos) << refusal();
}

}  // namespace
}  // namespace lappet
