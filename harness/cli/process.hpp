#pragma once

/// The process that the program is: what it must be allowed, and how it ends where a library ends it.
namespace hdmbench::commands {

/// Throws InputError where the system allows this process less open files or less stack than it needs: what
/// fails for that reason would be taken for damage of files, or be a crash.
void require_limits();

/// From now on a library or a driver that ends the process (exit(), or a crash) is said, and the exit status
/// is bad_input: 1 would be a disagreement. Left out where HDMBENCH_ASK_IN_PROCESS is in the environment:
/// then another program watches how this one ends.
void explain_sudden_end();

/// From now on what is printed to standard output is printable() text: names of files can have any bytes, and
/// an escape character would be an order to a terminal.
void print_printable();

/// Returns `status`, with which main() is to end.
[[nodiscard]] int ended_by_main(int status);

} // namespace hdmbench::commands
