#!/usr/bin/env python3
"""Fetch the native libraries that specforge links: libtorch (CPU) and MuJoCo.

Both come from their official wheels, pinned by version and sha256, and are unpacked into
third_party/. Nothing is installed. Running it again does nothing when the libraries are there.

A user with a libtorch of their own sets LIBTORCH to it, for the build, and SPECFORGE_OWN_LIBTORCH=1, which skips the
torch part here.
"""

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
MUJOCO_WHEELS = [("mujoco", MUJOCO_VERSION, "d66928d86a2d1b601bbaa4dc11db50214d17d5301bb8afd84721313b67ff0874")]


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


def install(name, version, wheels, place, finish):
    """Downloads, unpacks and finishes one library; the folder appears only when it is whole."""
    folder = TARGET / name
    stamp = folder / "build-version"
    if stamp.is_file() and stamp.read_text().strip() == version:
        return
    say(f"{name} {version}: downloading {', '.join(w[0] for w in wheels)}")
    TARGET.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory(dir=TARGET, prefix=f".{name}-") as temporary:
        downloads = Path(temporary) / "wheels"
        whole = Path(temporary) / name
        downloads.mkdir()
        unpack(download(wheels, downloads), place, whole)
        finish(whole)
        (whole / "build-version").write_text(version + "\n")
        if folder.exists():
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
    if os.environ.get("SPECFORGE_OWN_LIBTORCH"):
        say("SPECFORGE_OWN_LIBTORCH is set: libtorch is yours (LIBTORCH)")
    else:
        install("libtorch", TORCH_VERSION, TORCH_WHEELS, torch_place, finish_torch)
    install("mujoco", MUJOCO_VERSION, MUJOCO_WHEELS, mujoco_place, finish_mujoco)


if __name__ == "__main__":
    main()
