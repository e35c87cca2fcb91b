#include "render/ffmpeg.h"

#include <fmt/format.h>

#include <string_view>

namespace twin::render {
namespace {

/// Interval of key frames, after each of which the partial file is playable.
constexpr int kSecondsPerPiece = 2;

/// Exact arithmetic, at full chroma resolution.
constexpr const char* kScale =
    "scale=out_color_matrix=bt709:out_range=tv:"
    "flags=bicubic+accurate_rnd+full_chroma_int+bitexact";

using Words = std::vector<std::string>;

void Append(const Words& more, Words& words) {
  words.insert(words.end(), more.begin(), more.end());
}

/// Raw pictures. The queue lets ffmpeg read ahead while it encodes.
Words Input(const VideoSettings& settings) {
  return {"-hide_banner",
          "-nostdin",
          "-loglevel",
          "error",
          "-f",
          "rawvideo",
          "-pix_fmt",
          "rgb24",
          "-video_size",
          fmt::format("{}x{}", settings.width, settings.height),
          "-framerate",
          std::to_string(settings.fps),
          "-thread_queue_size",
          "4",
          "-i",
          "pipe:0"};
}

/// One thread and no version strings or dates: same pictures, same bytes.
Words Exact() {
  return {"-threads", "1", "-flags:v", "+bitexact", "-fflags", "+bitexact", "-map_metadata", "-1"};
}

/// Converted to BT.709 and tagged, because players otherwise guess the colours from the picture's
/// size. Fragmented and flushed, so that a truncated file is playable.
Words H264(const VideoSettings& settings) {
  return {"-filter_threads",
          "1",
          "-vf",
          kScale,
          "-colorspace",
          "bt709",
          "-color_primaries",
          "bt709",
          "-color_trc",
          "bt709",
          "-c:v",
          "libx264",
          "-preset",
          "veryfast",
          "-crf",
          std::to_string(settings.crf),
          "-pix_fmt",
          "yuv420p",
          "-g",
          std::to_string(kSecondsPerPiece * settings.fps),
          "-movflags",
          "+frag_keyframe+empty_moov+default_base_moof",
          "-flush_packets",
          "1",
          "-f",
          "mp4"};
}

/// Version 3 with a checksum per slice; every picture is a key frame.
Words Ffv1() {
  return {"-c:v",
          "ffv1",
          "-level",
          "3",
          "-slices",
          "4",
          "-slicecrc",
          "1",
          "-g",
          "1",
          "-pix_fmt",
          "bgr0",
          "-cluster_time_limit",
          std::to_string(1000 * kSecondsPerPiece),
          "-flush_packets",
          "1",
          "-f",
          "matroska"};
}

/// Fast compression: these pictures are for programs.
Words Pictures() {
  return {"-c:v", "png",           "-pred", "up", "-compression_level",
          "3",    "-start_number", "0",     "-f", "image2"};
}

/// The file name pattern of a folder's pictures.
std::string PatternIn(const std::filesystem::path& folder) {
  std::string pattern;
  for (const char c : folder.string()) pattern += c == '%' ? "%%" : std::string(1, c);
  return pattern + "/frame_%06d.png";
}

}  // namespace

std::vector<std::string> FfmpegArguments(const VideoSettings& settings, VideoFormat format,
                                         const std::filesystem::path& output) {
  Words words = Input(settings);
  switch (format) {
    case VideoFormat::kH264: Append(H264(settings), words); break;
    case VideoFormat::kFfv1: Append(Ffv1(), words); break;
    case VideoFormat::kPictures: Append(Pictures(), words); break;
  }
  Append(Exact(), words);
  const bool file = format != VideoFormat::kPictures;
  Append({"-y", "file:" + (file ? output.string() : PatternIn(output))}, words);
  return words;
}

}  // namespace twin::render
