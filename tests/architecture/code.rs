//! Our code as a compiler sees it: the modules of each crate, what they define, and which
//! paths they name. Tests are left out.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use cargo_metadata::Package;
use integration_tests::root;
use proc_macro2::Span;
use syn::punctuated::Punctuated;
use syn::visit::{self, Visit};
use syn::{Attribute, Expr, Item, Token, UseTree, Visibility};

use crate::METADATA;

/// Names from the root of a crate down; the root itself is empty.
pub(crate) type ModulePath = Vec<String>;

/// A crate's modules, by their paths.
pub(crate) struct Code {
    /// The package, by the name of its folder.
    pub(crate) package: String,
    pub(crate) modules: BTreeMap<ModulePath, Module>,
}

#[derive(Default)]
pub(crate) struct Module {
    /// The file that holds it, from the root of the workspace.
    pub(crate) file: PathBuf,
    /// The types that it defines: line, name, and whether it is `pub`.
    pub(crate) types: Vec<(usize, String, bool)>,
    /// Where the names that it imports come from.
    imports: BTreeMap<String, ModulePath>,
    /// The paths that it names, each with its line, as written.
    named: Vec<(usize, Vec<String>)>,
}

/// One module names something in another of the same crate.
#[derive(Debug, Clone)]
pub(crate) struct Arrow {
    pub(crate) from: ModulePath,
    pub(crate) to: ModulePath,
    pub(crate) file: PathBuf,
    pub(crate) target: PathBuf,
    pub(crate) line: usize,
    /// What is named, as written.
    pub(crate) name: String,
}

impl Code {
    /// Services, messages and tools: of each package the library, or the program if it has
    /// none. Tests and fuzz targets may do as they like.
    pub(crate) fn of_services_and_tools() -> Vec<Self> {
        let folders = ["schemas", "services", "tools"].map(|folder| root().join(folder));
        let is_there = |package: &&Package| {
            folders.iter().any(|folder| package.manifest_path.starts_with(folder))
        };
        let packages = METADATA.packages.iter().filter(is_there).map(|package| {
            let library = package.targets.iter().find(|target| target.is_lib());
            let target = library.or_else(|| package.targets.iter().find(|target| target.is_bin()));
            let target = target.unwrap_or_else(|| panic!("{} has no code", package.name));
            let mut modules = BTreeMap::new();
            read(target.src_path.as_std_path(), Vec::new(), &mut modules);
            Self { package: crate::ours(&package.name), modules }
        });
        packages.collect()
    }

    /// Every time that one module names another, in a `use` or in place.
    pub(crate) fn arrows(&self) -> Vec<Arrow> {
        let mut arrows = Vec::new();
        for (from, module) in &self.modules {
            for (line, named) in &module.named {
                let Some(path) = self.absolute(from, named) else { continue };
                let to = self.home(&path, 8);
                if to != *from {
                    let (file, name) = (module.file.clone(), named.join("::"));
                    let target = self.modules[&to].file.clone();
                    arrows.push(Arrow { from: from.clone(), to, file, target, line: *line, name });
                }
            }
        }
        arrows
    }

    /// A path as written in a module, from the crate's root; `None` for one that leads out
    /// of the crate.
    fn absolute(&self, module: &ModulePath, named: &[String]) -> Option<ModulePath> {
        let (mut path, mut rest) = match named[0].as_str() {
            "crate" => (Vec::new(), &named[1..]),
            "self" => (module.clone(), &named[1..]),
            "super" => (module.clone(), named),
            child => {
                let mut path = module.clone();
                path.push(child.to_owned());
                return self.modules.contains_key(&path).then(|| [module, named].concat());
            }
        };
        while rest.first().is_some_and(|name| name == "super") {
            path.pop();
            rest = &rest[1..];
        }
        path.extend_from_slice(rest);
        Some(path)
    }

    /// The module in which a path's last name is defined, re-exports followed.
    fn home(&self, path: &[String], patience: usize) -> ModulePath {
        let longest = (0..=path.len()).rev().find(|end| self.modules.contains_key(&path[..*end]));
        let (module, rest) = path.split_at(longest.unwrap_or(0));
        let imported = rest.first().and_then(|name| self.modules[module].imports.get(name));
        let Some(imported) = imported.filter(|_| patience > 0) else { return module.to_vec() };
        match self.absolute(&module.to_vec(), imported) {
            Some(path) => self.home(&path, patience - 1),
            None => module.to_vec(),
        }
    }
}

/// Reads a file and those of the modules that it declares.
fn read(file: &Path, path: ModulePath, modules: &mut BTreeMap<ModulePath, Module>) {
    let text = fs::read_to_string(file).unwrap_or_else(|error| panic!("{file:?}: {error}"));
    let parsed = syn::parse_file(&text).unwrap_or_else(|error| panic!("{file:?}: {error}"));
    read_items(file, path, &parsed.items, modules);
}

fn read_items(
    file: &Path,
    path: ModulePath,
    items: &[Item],
    modules: &mut BTreeMap<ModulePath, Module>,
) {
    let relative = file.strip_prefix(root()).expect("our files lie in the workspace");
    let mut reader = Reader { module: Module { file: relative.to_owned(), ..Module::default() } };
    for item in items {
        reader.visit_item(item);
        let Item::Mod(child) = item else { continue };
        if is_test(&child.attrs) {
            continue;
        }
        let mut below = path.clone();
        below.push(child.ident.to_string());
        match &child.content {
            Some((_, items)) => read_items(file, below, items, modules),
            None => read(&file_of(file, &child.ident.to_string()), below, modules),
        }
    }
    modules.insert(path, reader.module);
}

/// Where the module `child`, declared in `file`, is.
fn file_of(file: &Path, child: &str) -> PathBuf {
    let folder = file.parent().expect("a file lies in a folder");
    let stem = file.file_stem().expect("a file has a name").to_string_lossy();
    let folder = if stem == "lib" || stem == "main" { folder.into() } else { folder.join(&*stem) };
    folder.join(child).with_extension("rs")
}

fn is_test(attributes: &[Attribute]) -> bool {
    let is_test = |attribute: &Attribute| {
        let list = attribute.meta.require_list();
        list.is_ok_and(|list| list.path.is_ident("cfg") && list.tokens.to_string() == "test")
    };
    attributes.iter().any(is_test)
}

struct Reader {
    module: Module,
}

impl Reader {
    fn add_type(&mut self, name: &syn::Ident, visibility: &Visibility) {
        let is_public = matches!(visibility, Visibility::Public(_));
        self.module.types.push((line(name.span()), name.to_string(), is_public));
    }

    fn add_use(&mut self, before: &mut ModulePath, tree: &UseTree) {
        match tree {
            UseTree::Path(path) => {
                before.push(path.ident.to_string());
                self.add_use(before, &path.tree);
                before.pop();
            }
            UseTree::Group(group) => {
                group.items.iter().for_each(|tree| self.add_use(before, tree));
            }
            UseTree::Name(name) if name.ident == "self" => {
                self.import(name.ident.span(), before, None)
            }
            UseTree::Name(name) => {
                before.push(name.ident.to_string());
                self.import(name.ident.span(), before, None);
                before.pop();
            }
            UseTree::Rename(rename) => {
                before.push(rename.ident.to_string());
                self.import(rename.ident.span(), before, Some(rename.rename.to_string()));
                before.pop();
            }
            UseTree::Glob(glob) => {
                self.module.named.push((line(glob.star_token.spans[0]), before.clone()));
            }
        }
    }

    /// Reads parts of a macro, which do not live as long as the file.
    fn read_within(&mut self, items: &[Item]) {
        let mut within = Reader { module: Module::default() };
        items.iter().for_each(|item| within.visit_item(item));
        self.module.types.append(&mut within.module.types);
        self.module.named.append(&mut within.module.named);
    }

    fn import(&mut self, span: Span, path: &[String], name: Option<String>) {
        self.module.named.push((line(span), path.to_vec()));
        if let Some(name) = name.or_else(|| path.last().cloned()) {
            self.module.imports.insert(name, path.to_vec());
        }
    }
}

fn line(span: Span) -> usize {
    span.start().line
}

impl<'ast> Visit<'ast> for Reader {
    fn visit_item(&mut self, item: &'ast Item) {
        let attributes = match item {
            // Read by themselves.
            Item::Mod(_) => return,
            Item::Enum(item) => {
                self.add_type(&item.ident, &item.vis);
                &item.attrs
            }
            Item::Struct(item) => {
                self.add_type(&item.ident, &item.vis);
                &item.attrs
            }
            Item::Trait(item) => {
                self.add_type(&item.ident, &item.vis);
                &item.attrs
            }
            Item::Type(item) => {
                self.add_type(&item.ident, &item.vis);
                &item.attrs
            }
            Item::Impl(item) => &item.attrs,
            Item::Fn(item) => &item.attrs,
            Item::Use(item) => &item.attrs,
            Item::Const(item) => &item.attrs,
            // Items that a macro only adds to.
            Item::Macro(item) => {
                if let Ok(within) = item.mac.parse_body::<syn::File>() {
                    self.read_within(&within.items);
                }
                return;
            }
            _ => return visit::visit_item(self, item),
        };
        if !is_test(attributes) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        self.add_use(&mut Vec::new(), &item.tree);
    }

    fn visit_impl_item_fn(&mut self, method: &'ast syn::ImplItemFn) {
        if !is_test(&method.attrs) {
            visit::visit_impl_item_fn(self, method);
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names = path.segments.iter().map(|segment| segment.ident.to_string());
        let names: Vec<_> = names.collect();
        if path.leading_colon.is_none() && names.len() > 1 {
            self.module.named.push((line(path.segments[0].ident.span()), names));
        }
        visit::visit_path(self, path);
    }

    /// Arguments of macros, where they are expressions.
    fn visit_macro(&mut self, invoked: &'ast syn::Macro) {
        let arguments = Punctuated::<Expr, Token![,]>::parse_terminated;
        if let Ok(arguments) = invoked.parse_body_with(arguments) {
            arguments.iter().for_each(|argument| {
                // The visitor wants a longer life than the arguments have.
                let mut within = Reader { module: Module::default() };
                within.visit_expr(argument);
                self.module.named.append(&mut within.module.named);
            });
        }
        self.visit_path(&invoked.path);
    }
}
