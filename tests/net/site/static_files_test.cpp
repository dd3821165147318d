// The page's files as one directory has them: which copy of a file is sent to whom.
#include "net/site/static_files.h"

#include <gtest/gtest.h>

#include "support/temporary_folder.h"

namespace isostrata {
namespace {

class PackedFiles : public ::testing::Test {
 protected:
  PackedFiles() {
    // The build packs them; here their bytes only need to be told apart.
    for (const char* file : {"index.html", "assets/app-1a2b.js"}) {
      folder_.write(file, "plain");
      folder_.write(std::string(file) + ".br", "as br");
      folder_.write(std::string(file) + ".gz", "as gzip");
    }
    folder_.write("assets/small-3c4d.css", "a{}");
  }
  HttpResponse get(const std::string& path, const std::string& accepted, const std::string& if_none_match = "") {
    HttpRequest request{"GET", "/" + path, "", {}};
    if (!accepted.empty()) request.headers.emplace_back("accept-encoding", accepted);
    if (!if_none_match.empty()) request.headers.emplace_back("if-none-match", if_none_match);
    return StaticFiles(folder_.path()).get(request, parse_target("/" + path)->segments);
  }
  HttpResponse script(const std::string& accepted, const std::string& if_none_match = "") {
    return get("assets/app-1a2b.js", accepted, if_none_match);
  }
  static std::string value(const HttpResponse& response, const std::string& header) {
    for (const auto& [name, text] : response.headers)
      if (name == header) return text;
    return {};
  }
  testing::TemporaryFolder folder_;
};

TEST_F(PackedFiles, AreSentToWhoTakesThemAndSayWhatTheyAre) {
  for (const auto& [accepted, coding] : {std::pair<std::string, std::string>{"gzip, deflate, br, zstd", "br"},
                                         {"br", "br"},
                                         {"gzip", "gzip"},
                                         {"GZIP;q=0.5", "gzip"},
                                         {"br;q=0.2,gzip;q=0.8", "gzip"},
                                         {"br ; q=0, gzip", "gzip"},
                                         {"*", "br"},
                                         {"*;q=0.1, br;q=0", "gzip"},
                                         {"", ""},
                                         {"identity", ""},
                                         {"br;q=0, gzip;q=0", ""},
                                         {"*;q=0", ""},
                                         {"zstd", ""},
                                         {"brotli, x-gzip", ""},
                                         {"br;q=nonsense", ""},
                                         {",,;,q=1", ""}}) {
    const HttpResponse response = script(accepted);
    EXPECT_EQ(response.status, 200) << accepted;
    EXPECT_EQ(value(response, "Content-Encoding"), coding) << accepted;
    EXPECT_EQ(response.body, coding.empty() ? "plain" : "as " + coding) << accepted;
    EXPECT_EQ(value(response, "Vary"), "Accept-Encoding") << accepted;
    EXPECT_EQ(response.content_type, "text/javascript; charset=utf-8") << accepted;
    EXPECT_NE(value(response, "Cache-Control").find("immutable"), std::string::npos) << accepted;
  }
  EXPECT_EQ(get("", "br").body, "as br");
  EXPECT_EQ(get("", "br").content_type, "text/html; charset=utf-8");
}

TEST_F(PackedFiles, HaveTagsOfTheirOwnByWhichTheyAreNotSentAgain) {
  const std::string plain = value(script(""), "ETag"), br = value(script("br"), "ETag"), gzip = value(script("gzip"), "ETag");
  EXPECT_NE(plain, br);
  EXPECT_NE(br, gzip);
  EXPECT_EQ(script("br", br).status, 304);
  EXPECT_EQ(value(script("br", br), "Vary"), "Accept-Encoding");
  EXPECT_EQ(script("br", "W/" + gzip + ", W/" + br).status, 304);
  EXPECT_EQ(script("br", "*").status, 304);
  EXPECT_EQ(script("br", gzip).status, 200);
  EXPECT_EQ(script("identity", br).status, 200);
  EXPECT_EQ(script("br", br.substr(0, br.size() - 1)).status, 200);
}

TEST_F(PackedFiles, AFileWithoutThemIsTheSameForAll) {
  const HttpResponse response = get("assets/small-3c4d.css", "br, gzip");
  EXPECT_EQ(response.body, "a{}");
  EXPECT_EQ(value(response, "Content-Encoding") + value(response, "Vary"), "");
}

TEST_F(PackedFiles, ALinkInPlaceOfOneIsNotFollowed) {
  testing::TemporaryFolder outside;
  outside.write("secret", "a secret");
  std::filesystem::remove(folder_.path() / "index.html.br");
  std::filesystem::create_symlink(outside.path() / "secret", folder_.path() / "index.html.br");
  EXPECT_EQ(get("", "br").body, "plain");
}

}  // namespace
}  // namespace isostrata
