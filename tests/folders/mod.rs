//! Folders of the tests that need a project of their own.

use std::fs;
use std::path::Path;

/// Copies a folder with everything below it; links stay links, as those of a store's folder `tensorboard`.
pub fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("folders can be made");
    for entry in fs::read_dir(from).expect("folders are readable") {
        let path = entry.expect("entries are readable").path();
        let target = to.join(path.file_name().expect("entries have names"));
        if path.is_symlink() {
            let end = fs::read_link(&path).expect("links are readable");
            std::os::unix::fs::symlink(end, &target).expect("links can be made");
        } else if path.is_dir() {
            copy(&path, &target);
        } else {
            fs::copy(&path, &target).expect("files can be copied");
        }
    }
}
