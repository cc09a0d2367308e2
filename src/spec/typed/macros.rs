//! The macros that declare keys, kinds, words and forms.

/// Declares the keys of a table as a struct.
///
/// ```ignore
/// keys! {
///     /// A commanded speed.
///     pub struct Command {
///         /// Commanded forward speed.
///         #[range(-10.0, 10.0)]
///         speed: Sampled<MetrePerSecond>,
///         /// Time between two draws of the speed; without it one draw holds for the episode.
///         every: Option<Quantified<Second>>,
///         /// Time over which a new speed is approached linearly.
///         #[default("\"0 s\"")]
///         ramp: Quantified<Second>,
///     }
/// }
/// ```
///
/// The documentation of a field is that of the key. Attributes: `range` (inclusive, in SI units), `default`
/// (as TOML) and `length` (of a list). After the keys, `..name: Struct,` adds the keys of another
/// declaration; before them `+ name: Struct,` does.
macro_rules! keys {
    (
        $(#[$($about:tt)*])*
        $vis:vis struct $name:ident $(in $section:literal)? {
            $( + $head:ident : $of_head:ty, )*
            $( $(#[$attribute:ident $($argument:tt)*])* $key:ident : $ty:ty, )*
            $( .. $shared:ident : $of:ty, )*
        }
    ) => {
        $(#[$($about)*])*
        #[derive(Clone, Debug, PartialEq)]
        $vis struct $name {
            $(
                /// Keys that it shares with others.
                pub $head: $of_head,
            )*
            $(
                #[doc = concat!($( $crate::spec::typed::key_attribute!(doc $attribute $($argument)*) ),*)]
                pub $key: <$ty as $crate::spec::typed::Typed>::Value,
            )*
            $(
                /// Keys that it shares with others.
                pub $shared: $of,
            )*
        }

        #[allow(non_upper_case_globals, dead_code, reason = "each constant is named after its key")]
        impl $name {
            $(
                #[doc = concat!("The key `", stringify!($key), "`.")]
                pub const $key: $crate::spec::typed::Key<Self, <$ty as $crate::spec::typed::Typed>::Present> =
                    $crate::spec::typed::Key::new($crate::spec::typed::key_name(stringify!($key)));
            )*
        }

        impl $crate::spec::typed::Keys for $name {
            const PARAMS: &'static [$crate::spec::Param] = {
                const OWN: &[$crate::spec::Param] = &[$({
                    let name = $crate::spec::typed::key_name(stringify!($key));
                    let param = $crate::spec::Param::of::<$ty>(name);
                    let doc =
                        concat!($( $crate::spec::typed::key_attribute!(doc $attribute $($argument)*) ),*);
                    let param = param.doc(doc.trim_ascii());
                    $(
                        let param = $crate::spec::typed::key_attribute!(param param $attribute $($argument)*);
                    )*
                    param
                }),*];
                const LISTS: &[&[$crate::spec::Param]] = &[
                    $( <$of_head as $crate::spec::typed::Keys>::PARAMS, )*
                    OWN
                    $( , <$of as $crate::spec::typed::Keys>::PARAMS )*
                ];
                const COUNT: usize = $crate::spec::typed::count(LISTS);
                &$crate::spec::typed::join::<COUNT>(LISTS)
            };

            #[allow(unused_variables, reason = "a table may have no keys")]
            fn of_table(table: &$crate::spec::Table) -> Option<Self> {
                Some(Self {
                    $( $head: <$of_head as $crate::spec::typed::Keys>::of_table(table)?, )*
                    $( $key: $crate::spec::typed::read_key::<$ty>(table, Self::$key.name, Self::PARAMS)?, )*
                    $( $shared: <$of as $crate::spec::typed::Keys>::of_table(table)?, )*
                })
            }
        }

        impl $crate::spec::typed::Typed for $name {
            type Value = Self;
            type Present = Self;
            const TY: $crate::spec::Ty = $crate::spec::Ty::Table(<Self as $crate::spec::typed::Keys>::PARAMS);
            fn read(value: &$crate::spec::Value) -> Option<Self> {
                match value {
                    $crate::spec::Value::Table(table) => <Self as $crate::spec::typed::Keys>::of_table(table),
                    _ => None,
                }
            }
        }

        $(
            impl $crate::spec::typed::InSection for $name {
                const SECTION: &'static str = $section;
            }

            impl $crate::spec::typed::Part for $name {
                fn of_section(section: $crate::spec::Section) -> Option<Self> {
                    <Self as $crate::spec::typed::Keys>::of_table(section.table())
                }
            }
        )?
    };
}

/// What an attribute of a key sets: its documentation, or a property of its [`Param`](crate::spec::Param).
macro_rules! key_attribute {
    (doc doc = $line:literal) => {
        $line
    };
    (doc $($other:tt)*) => {
        ""
    };
    (param $param:ident doc = $line:literal) => {
        $param
    };
    (param $param:ident range($low:expr, $high:expr)) => {
        $param.range($low, $high)
    };
    (param $param:ident default($toml:expr)) => {
        $param.or($toml)
    };
    (param $param:ident length($length:expr)) => {
        $param.length($length)
    };
}

/// Declares a kind: its keys as with `keys!`, its word, and what it reads from the simulation. The Markdown
/// file of that name next to the source file is its page and the documentation of the struct.
///
/// ```ignore
/// kind! {
///     pub struct Torque = "torque", needs [Torque] {
///         /// One over the torque at which the term has fallen to 37 %.
///         #[range(1e-9, 1e9)]
///         k: Quantified<PerNewtonMetre>,
///     }
/// }
/// ```
macro_rules! kind {
    (
        $(#[$($about:tt)*])*
        $vis:vis struct $name:ident $(in $section:literal)? = $word:literal $(, needs [$($signal:ident),*])? {
            $($keys:tt)*
        }
    ) => {
        $crate::spec::typed::keys! {
            #[doc = include_str!(concat!($word, ".md"))]
            $(#[$($about)*])*
            $vis struct $name $(in $section)? {
                $($keys)*
            }
        }

        impl $crate::spec::typed::Declared for $name {
            const KIND: &'static $crate::spec::Kind = &$crate::spec::Kind {
                name: $word,
                since: $crate::spec::Edition::ONE,
                doc: include_str!(concat!($word, ".md")),
                params: <Self as $crate::spec::typed::Keys>::PARAMS,
                needs: &[$($($crate::spec::Signal::$signal),*)?],
            };
        }
    };
}

/// Declares the words that a key takes.
///
/// ```ignore
/// choice! {
///     /// Whose draws a factor has.
///     pub enum Per {
///         /// Every joint has its own.
///         Joint = "joint",
///         /// The robot has one for all.
///         Robot = "robot",
///     }
/// }
/// ```
macro_rules! choice {
    (
        $(#[$($about:tt)*])*
        $vis:vis enum $name:ident { $( $(#[$($attribute:tt)*])* $variant:ident = $word:literal ),* $(,)? }
    ) => {
        $(#[$($about)*])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        $vis enum $name { $( $(#[$($attribute)*])* $variant ),* }

        impl $name {
            /// The choices, in the order of the declaration.
            #[allow(dead_code, reason = "not every choice is listed")]
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// The words, in the order of the declaration.
            pub const WORDS: &'static [&'static str] = &[$($word),*];

            /// The word in a spec.
            #[allow(dead_code, reason = "not every choice is printed")]
            pub const fn word(self) -> &'static str {
                match self { $( Self::$variant => $word ),* }
            }

            /// The choice of this word.
            #[allow(dead_code, reason = "not every choice is read elsewhere than in specs")]
            pub fn named(word: &str) -> Option<Self> {
                match word {
                    $( $word => Some(Self::$variant), )*
                    _ => None,
                }
            }
        }

        impl $crate::spec::typed::Typed for $name {
            type Value = Self;
            type Present = Self;
            const TY: $crate::spec::Ty = $crate::spec::Ty::Choice(Self::WORDS);
            fn read(value: &$crate::spec::Value) -> Option<Self> {
                match value {
                    $crate::spec::Value::Text(word) => Self::named(word),
                    _ => None,
                }
            }
        }
    };
}

/// Declares a value with several forms, which the decoder distinguishes by their shapes; the first match
/// wins.
///
/// ```ignore
/// either! {
///     /// The derivative gain of a servo.
///     pub enum Damping {
///         /// How it follows the stiffness.
///         Rule(DampingRule),
///         /// A share of the robot's own.
///         Share(Ratio<OwnDamping>),
///     }
/// }
/// ```
macro_rules! either {
    (
        $(#[$($about:tt)*])*
        $vis:vis enum $name:ident { $( $(#[$($attribute:tt)*])* $variant:ident($ty:ty) ),* $(,)? }
    ) => {
        $(#[$($about)*])*
        #[derive(Clone, Debug, PartialEq)]
        $vis enum $name { $( $(#[$($attribute)*])* $variant(<$ty as $crate::spec::typed::Typed>::Value) ),* }

        impl $crate::spec::typed::Typed for $name {
            type Value = Self;
            type Present = Self;
            const TY: $crate::spec::Ty =
                $crate::spec::Ty::OneOf(&[$(<$ty as $crate::spec::typed::Typed>::TY),*]);
            fn read(value: &$crate::spec::Value) -> Option<Self> {
                $(
                    if let Some(value) = <$ty as $crate::spec::typed::Typed>::read(value) {
                        return Some(Self::$variant(value));
                    }
                )*
                None
            }
        }
    };
}

/// Declares the references of ratios.
macro_rules! reference {
    ($($(#[$($about:tt)*])* $vis:vis $name:ident = $words:literal $(or $measure:ident)?;)*) => {$(
        $(#[$($about)*])*
        $vis struct $name;
        impl $crate::spec::typed::Reference for $name {
            const OF: &'static str = $words;
            $( const MEASURE: Option<$crate::quantity::Measure> = Some($crate::quantity::Measure::$measure); )?
        }
    )*};
}

/// Declares a section that has exactly one kind, as an enum of the kinds' structs.
///
/// ```ignore
/// section! {
///     /// What the policy commands.
///     pub enum Action in "action", "action" { position: Position, torque: Torque }
/// }
/// ```
macro_rules! section {
    (
        $(#[$($about:tt)*])*
        $vis:vis enum $name:ident in $section:literal,
        $noun:literal { $( $module:ident : $kind:ident ),* $(,)? }
    ) => {
        $(#[$($about)*])*
        #[derive(Clone, Debug, PartialEq)]
        $vis enum $name {
            $(
                #[doc = concat!("The kind of `", stringify!($module), "`.")]
                $kind($module::$kind),
            )*
        }

        #[allow(dead_code, reason = "not every section is printed")]
        impl $name {
            /// The word of its kind in a spec.
            pub fn kind(&self) -> &'static str {
                match self {
                    $( Self::$kind(_) => <$module::$kind as $crate::spec::typed::Declared>::KIND.name ),*
                }
            }
        }

        /// Every kind of this section, sorted by name.
        pub static KINDS: &[&$crate::spec::Kind] =
            &[$( <$module::$kind as $crate::spec::typed::Declared>::KIND ),*];

        /// Their descriptors.
        pub fn kinds() -> Vec<&'static $crate::spec::Kind> {
            KINDS.to_vec()
        }

        impl $crate::spec::typed::SectionKinds for $name {}

        impl $crate::spec::typed::HasKinds for $name {
            const KINDS: $crate::spec::Kinds = $crate::spec::Kinds { section: $section, noun: $noun,
                all: kinds };
        }

        impl $crate::spec::typed::Part for $name {
            fn of_section(section: $crate::spec::Section) -> Option<Self> {
                let word = section.kind()?;
                $(
                    if word == <$module::$kind as $crate::spec::typed::Declared>::KIND.name {
                        let typed = <$module::$kind as $crate::spec::typed::Keys>::of_table(section.table());
                        return typed.map(Self::$kind);
                    }
                )*
                None
            }
        }
    };
}

/// Declares a section of named terms, whose kinds come from the function `kinds` of the module.
///
/// ```ignore
/// terms! {
///     /// What earns reward.
///     pub struct Rewards in "reward", "reward term";
/// }
/// ```
macro_rules! terms {
    ($(#[$($about:tt)*])* $vis:vis struct $name:ident in $section:literal, $noun:literal;) => {
        $(#[$($about)*])*
        $vis struct $name;

        impl $crate::spec::typed::HasKinds for $name {
            const KINDS: $crate::spec::Kinds = $crate::spec::Kinds { section: $section, noun: $noun,
                all: kinds };
        }
    };
}

pub(crate) use {choice, either, key_attribute, keys, kind, reference, section, terms};
