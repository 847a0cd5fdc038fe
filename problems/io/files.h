// Files as bytes: reading, provenance, and writing that is whole or not at all.
#pragma once

#include <string>

namespace sagitta {

// Throws InputError when the file is absent or cannot be read.
std::string ReadTextFile(const std::string& path);

// Writes to a temporary name in the same folder and renames. Throws InputError.
void WriteTextFile(const std::string& path, const std::string& text);

// Makes the folder if it is absent and proves that it can be written. Throws
// InputError; leaves nothing behind.
void PrepareOutputFolder(const std::string& path);

// The line of the first byte that is no UTF-8; 0: all is.
int LineOfInvalidUtf8(const std::string& bytes);

// Lower-case hexadecimal digest.
std::string Sha256(const std::string& bytes);

// The shortest decimal text that reads back to the same double.
std::string FormatNumber(double value);

}  // namespace sagitta
