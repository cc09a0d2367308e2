#!/usr/bin/env python3
"""Fetch the native libraries of specforge: MuJoCo, and with the argument `torch` also libtorch (CPU).

Both come from their official wheels, pinned by version and sha256, and are unpacked into
third_party/. Nothing is installed. Running it again hashes what is there (2 s) and downloads only what is
missing or differs from the pinned digests: the version in `build-version` is a claim, not evidence.

A user with a libtorch of their own sets LIBTORCH to it, for the build, and SPECFORGE_OWN_LIBTORCH=1, which skips the
torch part here.
"""

import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TARGET = ROOT / "third_party"

TORCH_VERSION = "2.13.0"
MUJOCO_VERSION = "3.17.0"
TORCH_WHEELS = [
    ("torch", TORCH_VERSION, "60fcdcb2f3876e21146cb4524ef06397d727ca9ad5f020818547e25075fe3cb7"),
    ("nvidia-cuda-runtime", "13.0.96", "7f82250d7782aa23b6cfe765ecc7db554bd3c2870c43f3d1821f1d18aebf0548"),
    ("nvidia-cuda-cupti", "13.0.85", "4eb01c08e859bf924d222250d2e8f8b8ff6d3db4721288cf35d14252a4d933c8"),
]
# sha256 of the unpacked files. A folder stands for all its files; `libtorch.so` is the linker script of `finish_torch`.
TORCH_FILES = {
    "include/": "dd569a34e48bf4fbefbbfad13b676bc00fbdf041ec8e7bb285637998a7f37442",
    "lib/libc10.so": "b83ea50e9171c7e3455c19f9ff2c7d21d457a7b8231e9c4ea1b6e032ae1156d5",
    "lib/libcudart.so.13": "96c42e418cec19054186b9429c321603cc190bf26a18104e19408117a2a817b0",
    "lib/libcupti.so.13": "e2f9ed861fe27c492b8bb52b5e3220ef5120f3edcda36312e96b7fd8a186be3e",
    "lib/libgomp.so.1": "e28fb2896a3d612b46a27d7f8ef840d34c9efbc29b70a044c42095fb94856890",
    "lib/libshm.so": "f16b69a620993c61f2471857fbba27d6343ce282c632e5743633f8b3e6d70ed0",
    "lib/libtorch.so": "935528e009e7235be5a8fd3fe5dbfcc303fee8869a9d71da216bb3dafe981a3e",
    "lib/libtorch_cpu.so": "096eed6e217377ccda4d50693b680e2771709c01f58fe52717835b017fed9c58",
}
MUJOCO_WHEELS = [("mujoco", MUJOCO_VERSION, "d66928d86a2d1b601bbaa4dc11db50214d17d5301bb8afd84721313b67ff0874")]
MUJOCO_FILES = {
    "include/": "87c1c20b8994adc9239c6b847d3cb55ee19462d62e479a83cd4018c078330d0d",
    "lib/libmujoco.so": f"link to libmujoco.so.{MUJOCO_VERSION}",
    f"lib/libmujoco.so.{MUJOCO_VERSION}": "23496b023ee80fb61ab71167e94bc649f9941710fde96b18bb8204fb332523ad",
}


def say(text):
    """Progress goes to stderr, like every other message of the build."""
    print(f"fetch-native: {text}", file=sys.stderr, flush=True)


def download(wheels, folder):
    """Downloads the wheels into the folder, checked against their sha256 by pip."""
    requirements = Path(folder) / "requirements.txt"
    requirements.write_text("".join(f"{n}=={v} --hash=sha256:{h}\n" for n, v, h in wheels))
    command = [
        sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check",
        "--no-deps", "--require-hashes", "--only-binary=:all:",
        "--python-version", "311", "--implementation", "cp", "--abi", "cp311", "--abi", "none",
        *(f"--platform=manylinux_2_{minor}_x86_64" for minor in range(28, 16, -1)),
        "--dest", str(folder), "--requirement", str(requirements),
    ]
    if subprocess.run(command).returncode != 0:
        names = ", ".join(f"{n} {v}" for n, v, _ in wheels)
        sys.exit(f"fetch-native: error: pip could not download {names} (is the network reachable, and pip installed?)")
    return sorted(Path(folder).glob("*.whl"))


def unpack(wheels, wanted, into):
    """Writes the wanted members of the wheels below the folder; `wanted` maps a member to its place or None."""
    for wheel in wheels:
        with zipfile.ZipFile(wheel) as archive:
            for member in archive.namelist():
                place = wanted(member)
                if place is None or member.endswith("/"):
                    continue
                path = into / place
                path.parent.mkdir(parents=True, exist_ok=True)
                with archive.open(member) as source, open(path, "wb") as sink:
                    shutil.copyfileobj(source, sink, 1 << 20)
                if ".so" in path.name:
                    path.chmod(0o755)


def torch_place(member):
    """Where a member of the torch and CUDA wheels goes, or None when it is not needed on a CPU."""
    name = member.rsplit("/", 1)[-1]
    if member.startswith("torch/include/"):
        return member.removeprefix("torch/")
    keep = ("libc10.so", "libtorch_cpu.so", "libgomp", "libcudart.so", "libcupti.so", "libshm.so")
    if name.startswith(keep) and ".so" in name:
        return f"lib/{name}"
    return None


def mujoco_place(member):
    """Where a member of the MuJoCo wheel goes, or None."""
    name = member.rsplit("/", 1)[-1]
    if name == f"libmujoco.so.{MUJOCO_VERSION}":
        return f"lib/{name}"
    if member.startswith("mujoco/include/"):
        return member.removeprefix("mujoco/")
    return None


def digest(path):
    """What a file is: where it leads, or the sha256 of its bytes."""
    if path.is_symlink():
        return f"link to {os.readlink(path)}"
    if not path.is_file():
        return "not a file"
    found = hashlib.sha256()
    with open(path, "rb") as file:
        while block := file.read(1 << 20):
            found.update(block)
    return found.hexdigest()


def files(folder):
    """The files below a folder as relative paths, sorted; links are files, whatever they lead to."""
    found = []
    for parent, folders, names in os.walk(folder):
        links = [name for name in folders if Path(parent, name).is_symlink()]
        found += [Path(parent, name).relative_to(folder).as_posix() for name in [*names, *links]]
    return sorted(found)


def contents(folder, pinned):
    """The digest of every file below the folder; the files of a pinned subfolder have one together."""
    found, trees = {}, {place: hashlib.sha256() for place in pinned if place.endswith("/")}
    for path in files(folder):
        tree = next((place for place in trees if path.startswith(place)), None)
        if tree is None:
            found[path] = digest(folder / path)
        else:
            trees[tree].update(f"{path} {digest(folder / path)}\n".encode())
    return found | {place: tree.hexdigest() for place, tree in trees.items()}


def faults(folder, version, pinned):
    """How the folder differs from the pinned files; an extra library counts, because the loader would find it."""
    if not folder.is_dir():
        return ["it is missing"]
    expected = pinned | {"build-version": hashlib.sha256(f"{version}\n".encode()).hexdigest()}
    found = contents(folder, pinned)
    names = sorted(expected.keys() | found.keys())
    words = {True: "is missing", False: "differs from the pinned file"}
    extra = [f"{name} does not belong there" for name in names if name not in expected]
    return extra + [f"{n} {words[n not in found]}" for n in names if n in expected and found.get(n) != expected[n]]


def install(name, version, wheels, pinned, place, finish):
    """Makes sure that one library is there, file by file as pinned; the folder appears only when it is whole."""
    folder = TARGET / name
    wrong = faults(folder, version, pinned)
    if not wrong:
        return
    if folder.exists():
        say(f"{name} {version} is fetched again: {'; '.join(wrong[:5])}")
    say(f"{name} {version}: downloading {', '.join(w[0] for w in wheels)}")
    TARGET.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory(dir=TARGET, prefix=f".{name}-") as temporary:
        downloads = Path(temporary) / "wheels"
        whole = Path(temporary) / name
        downloads.mkdir()
        unpack(download(wheels, downloads), place, whole)
        finish(whole)
        (whole / "build-version").write_text(version + "\n")
        wrong = faults(whole, version, pinned)
        if wrong:
            sys.exit(f"fetch-native: error: the wheels of {name} {version} are not as pinned: {'; '.join(wrong[:5])}")
        if folder.is_symlink() or folder.is_file():
            folder.unlink()
        elif folder.exists():
            shutil.rmtree(folder)
        os.rename(whole, folder)
    say(f"{name} {version}: ready in third_party/{name}")


def finish_torch(folder):
    """The wheel's libtorch.so links CUDA; a linker script takes its place."""
    (folder / "lib" / "libtorch.so").write_text("INPUT(-ltorch_cpu)\n")


def finish_mujoco(folder):
    """The name that the linker looks for."""
    (folder / "lib" / "libmujoco.so").symlink_to(f"libmujoco.so.{MUJOCO_VERSION}")


def main():
    if sys.platform != "linux" or os.uname().machine != "x86_64":
        sys.exit("fetch-native: error: the pinned wheels are for Linux on x86_64; elsewhere set LIBTORCH and MUJOCO_DYNAMIC_LINK_DIR")
    unknown = [word for word in sys.argv[1:] if word != "torch"]
    if unknown:
        sys.exit(f"fetch-native: error: unknown argument {unknown[0]!r}; the only one is `torch`")
    if "torch" in sys.argv[1:]:
        if os.environ.get("SPECFORGE_OWN_LIBTORCH"):
            say("SPECFORGE_OWN_LIBTORCH is set: libtorch is yours (LIBTORCH)")
        else:
            install("libtorch", TORCH_VERSION, TORCH_WHEELS, TORCH_FILES, torch_place, finish_torch)
    install("mujoco", MUJOCO_VERSION, MUJOCO_WHEELS, MUJOCO_FILES, mujoco_place, finish_mujoco)


if __name__ == "__main__":
    main()
