# SPDX-License-Identifier: GPL-3.0-or-later
"""French for the labels of panels, menus and properties. Blender's own translations come first where it has the same words."""
import bpy

CONTEXT = "Sluice"  # The context of words that Blender translates otherwise: its Exit leaves the program, its Tint is a verb.

FRENCH = {
    # the edit and its parts
    "Light Edit": "Édition de lumière", "Light Edits": "Éditions de lumière", "Entry": "Entrée", "Exits": "Sorties", "Role": "Rôle",
    "Expression": "Expression", "Expressions": "Expressions", "Enabled": "Active", "Repeat": "Répéter", "Amount": "Part",
    "Feather": "Adoucir le bord", "Order": "Ordre", "Offset": "Décalage", "Solo": "Seule",
    "Intensity": "Intensité", "Hue Shift": "Rotation de teinte", "Tint": "Coloration", "Keep Brightness": "Garder la luminosité",
    "Intensity Texture": "Texture d'intensité", "Hue Shift Texture": "Texture de teinte", "Texture": "Texture",
    "Normal Map": "Carte de normales", "Light that arrived here": "Lumière arrivée ici", "Own": "Personnelles",
    "Choose the entry whose light leaves here": "Choisir l'entrée dont la lumière sort ici",
    "No exit: the light is absorbed": "Aucune sortie : la lumière est absorbée",
    # what is done to it
    "Add Light Edit": "Ajouter une édition de lumière", "Add Exit": "Ajouter une sortie", "Select Exits": "Sélectionner les sorties",
    "Link Exits to Entry": "Lier les sorties à l'entrée", "Insert Name": "Insérer un nom", "Set Expression": "Choisir l'expression",
    "Load Expression": "Charger l'expression", "Save Expression": "Enregistrer l'expression", "Take This Light": "Prendre cette lumière",
    "Edit Light Here": "Éditer la lumière ici", "Light That Arrives Here": "Lumière qui arrive ici",
    "How This Was Measured": "Comment cela a été mesuré", "Enable Light Edits": "Activer les éditions",
    "Change Light": "Changer la lumière", "Move": "Déplacer", "Copy": "Copier", "Move to Cursor": "Déplacer au curseur",
    "Copy to Cursor": "Copier au curseur", "Recolour": "Recolorer", "Dim": "Atténuer", "Remove": "Retirer", "Apply": "Appliquer",
    # kinds of light
    "Caustic": "Caustique", "Straight Light": "Lumière directe", "Colour Bleeding": "Débordement de couleur",
    "All Indirect Light": "Toute lumière indirecte", "Everything": "Toute la lumière", "From This Lamp…": "De cette lampe…",
    "Through This Object…": "À travers cet objet…", "Colour of This Object…": "Couleur de cet objet…",
    "What the Eye Sees": "Ce que l'œil voit", "All Reflections": "Tous les reflets",
    # layers
    "Light Layers": "Calques de lumière", "Add Light Layer": "Ajouter un calque de lumière",
    "Active Light Layer": "Calque de lumière actif",
    "Remove Light Layer": "Retirer le calque de lumière", "Move Light Layer": "Déplacer le calque de lumière",
    # render passes
    "Albedo": "Albédo", "Edited": "Éditée", "Emission": "Émission", "Noise": "Bruit", "Bias": "Biais", "Data": "Données", "Quality": "Qualité",
    "Depth": "Profondeur", "Normal": "Normale", "Combined": "Combinée",
    "The compositor asks for it too": "Le compositeur la demande aussi",
    # what runs, and how accurate it is
    "What Will Be Simulated": "Ce qui sera simulé", "Effects": "Effets", "Effect": "Effet", "Accuracy": "Précision", "Share": "Part de l'erreur",
    "Blur": "Flou", "Show Curve": "Montrer la courbe", "What This Number Is": "Ce qu'est ce nombre",
    "Make Report": "Faire un rapport",
    # noise removed
    "Set Up Denoising": "Mettre en place le débruitage", "Denoise": "Débruiter", "Denoise Viewport": "Débruiter la vue", "Denoising": "Débruitage",
    "Noisy Image": "Image bruitée",
    # the render
    "Sampling": "Échantillonnage", "Passes": "Passes", "Photons": "Photons", "Seed": "Graine", "Animated Seed": "Graine animée",
    "Adaptive Sampling": "Échantillonnage adaptatif",
    "Error Target": "Erreur visée", "Time Limit": "Limite de temps", "Max Depth": "Profondeur maximale",
    "Max Edits per Path": "Éditions par chemin", "Specular Threshold": "Seuil spéculaire", "Light Paths": "Chemins de lumière",
    "Arriving": "Arrivant", "Direct": "Directe", "Caustics": "Caustiques", "Edited Light": "Lumière éditée", "Indirect": "Indirecte",
}
_OWN = {"None": "Aucun", "Entry": "Entrée", "Exit": "Sortie", "Role": "Rôle", "Tint": "Coloration"}


def _table() -> dict[str, dict[tuple[str, str], str]]:
    """Words in every context that Blender may ask for: labels, operators, our own."""
    words = {(context, word): told for context in ("*", "Operator") for word, told in FRENCH.items()}
    words.update({(CONTEXT, word): told for word, told in _OWN.items()})
    return {locale: words for locale in ("fr_FR", "fr")}  # Blender 4.5 has the shorter one.


def register() -> None:
    bpy.app.translations.register(__package__, _table())


def unregister() -> None:
    bpy.app.translations.unregister(__package__)
